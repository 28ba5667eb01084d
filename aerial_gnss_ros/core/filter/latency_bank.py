# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A bank of Kalman filters, one for each candidate latency, with the fit of the boxes to each.

With the right latency robots stay or move smoothly; with a wrong one they seem to move with the
drone. Each filter tracks each robot separately (position and velocity in `map`, an extended Kalman
filter on pixels) and treats the platform's slow errors as process noise of the robot: by how much
they change, and by how much a camera that moves shows robots elsewhere with them. Errors common
to all robots therefore count once: the cost is the mean over robots, not the sum.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.filter.latency_views import Mask, Views, by_pose
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.models.measurement_model import level_axes
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import ANGLES, LATENCY, PlatformModel
from aerial_gnss_ros.core.numerics.gaussian import inverse, mahalanobis

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LatencyBankTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    most_robots: int = 4
    """Greatest number of robots: more add little, as their common errors are the platform's.
    Judged."""
    forget_s: float = 2.0
    """A robot unseen for longer is initialised again, s. Judged."""
    drift_density: float = 0.1
    """Apparent acceleration that the platform's slow errors cause as the view changes, root of its
    spectral density, m/s^1.5. Judged."""
    feigned_speed_mps: float = 0.3
    """Apparent speed that they cause, one sigma, m/s. Judged."""
    huber_latency: float = 3.0
    """Normalised residual beyond which a box is down-weighted (Huber). Judged."""
    out_of_view_cost: float = 30.0
    """Cost of a latency that puts a detected robot out of view. Judged."""
    lost_squared: float = 40.0
    """Normalised squared residual from which a robot begins anew at its box: what jumped, or began
    to turn by itself, costs once, and at all latencies alike. Judged."""
    most_squared: float = 25.0
    """Upper bound of a normalised squared residual when the noise level is judged. Judged."""


TUNING = LatencyBankTuning()


@dataclass(frozen=True)
class BankObservation:
    """Boxes of labelled robots in one image.

    Attributes:
        stamp_ns: of the image less the configured latency, ns.
        camera: lens and image.
        pixels: (2,) by robot.
        fix_covariance: (2, 2) East, North of the fix itself, m²; None: as configured.
    """

    stamp_ns: int
    camera: CameraModel
    pixels: dict[str, Array]
    fix_covariance: Array | None = None


@dataclass(frozen=True)
class LatencyFit:
    """Fit of one image's boxes to each of h latencies, averaged over robots.

    Attributes:
        cost: (h,) -2 log likelihood up to a constant; linear beyond `TUNING.huber_latency`.
        squares: (h,) normalised squared residual; 2 is expected.
        size: (h,) log determinant of the residual's covariance.
        noise: (h,) trace of the pose's white noise in units of the residual's covariance.
    """

    cost: Array
    squares: Array
    size: Array
    noise: Array


class LatencyBank:
    """Tracks robots at each of h candidate latencies.

    Args:
        model: measurement noise and platform errors.
        motion: motion model of the robots.
        count: h.
    """

    def __init__(self, model: PlatformModel, motion: MotionModel, count: int) -> None:
        self._model = model
        self._acceleration = math.hypot(motion.acceleration, TUNING.drift_density)
        self._speed = math.hypot(motion.speed_sigma, TUNING.feigned_speed_mps)
        self._count = count
        self.reset()

    def reset(self) -> None:
        """Forget all robots."""
        self._seen_ns: dict[str, int] = {}  # in the order of the robots in the arrays
        self._state = np.zeros((self._count, 0, 4))
        self._covariance = np.zeros((self._count, 0, 4, 4))
        self._views: Views | None = None
        self._level = 1.0

    def update(
        self,
        now: BankObservation,
        passed: float,
        positions: Array,
        rotations: Array,
        anew: Mask | None = None,
        interpolation: Array | None = None,
        level: float = 1.0,
    ) -> LatencyFit | None:
        """Update with an image; return its fit, None if no robot was known before.

        Args:
            now: the boxes.
            passed: time since the previous image, s.
            positions: (h, 3) of the camera for each latency, m.
            rotations: (h, 3, 3) camera FLU in `map`.
            anew: (h,) whether robots begin anew at their boxes; None: none do.
            interpolation: (h, 6) variances of the poses, see `Views`.
            level: factor by which white noise of boxes and poses is larger than stated; those of
                slow errors of compass and gimbal are likely to be so, too.
        """
        self._level = level
        self._forget(now.stamp_ns)
        views = Views(positions, rotations @ FLU_FROM_OPTICAL, interpolation)
        if self._seen_ns and passed > 0.0:
            self._predict(passed, now.fix_covariance, views, rotations)
        self._views = views
        names = list(self._seen_ns)
        known = [name for name in names if name in now.pixels]
        fit = None
        if known:
            pixels = np.array([now.pixels[name] for name in known])
            slots = [names.index(one) for one in known]
            fit = self._correct(now.camera, slots, pixels, views)
            if anew is not None and anew.any():
                self._begin_anew(now.camera, slots, pixels, views, anew[:, None])
            self._seen_ns.update(dict.fromkeys(known, now.stamp_ns))
        fresh = [name for name in now.pixels if name not in names][
            : TUNING.most_robots - len(names)
        ]
        if fresh:
            self._begin(now, fresh, views)
        return fit

    @property
    def _white(self) -> Array:
        """Variances (6,) of the poses' white noise."""
        return self._level * self._model.white

    def _forget(self, stamp_ns: int) -> None:
        since = [stamp_ns - seen for seen in self._seen_ns.values()]
        kept = [i for i, unseen in enumerate(since) if unseen <= TUNING.forget_s * 1e9]
        if len(kept) < len(since):
            names = list(self._seen_ns)
            self._seen_ns = {names[i]: self._seen_ns[names[i]] for i in kept}
            self._state, self._covariance = self._state[:, kept], self._covariance[:, kept]

    def _predict(
        self, passed: float, fix_covariance: Array | None, views: Views, rotations: Array
    ) -> None:
        P, x, q = self._covariance, self._state, self._acceleration**2
        x[..., :2] += passed * x[..., 2:]
        P[..., :2, :] += passed * P[..., 2:, :]
        P[..., :2] += passed * P[..., 2:]
        noise = np.array([[passed**3 / 3.0, passed**2 / 2.0], [passed**2 / 2.0, passed]])
        P += np.kron(q * noise, np.eye(2))
        by_errors = np.eye(6)
        by_errors[3:, 3:] = level_axes(rotations[len(rotations) // 2])
        moved = by_pose(views.offsets(x[..., :2])) @ by_errors
        slow = self._model.stationary(fix_covariance)[:LATENCY, :LATENCY].copy()
        slow[ANGLES, ANGLES] *= self._level
        time = self._model.correlation_time_s
        if time > 0.0:
            P[..., :2, :2] += moved @ slow @ moved.swapaxes(2, 3) * (2.0 * passed / time)
        if self._views is not None:
            # Errors that last show places elsewhere as soon as the camera moves.
            change = moved - by_pose(self._views.offsets(x[..., :2])) @ by_errors
            P[..., :2, :2] += change @ slow @ change.swapaxes(2, 3)

    def _correct(
        self, camera: CameraModel, slots: list[int], pixels: Array, views: Views
    ) -> LatencyFit:
        x, P = self._state[:, slots], self._covariance[:, slots]
        predicted, by_place, white, seen = views.measured(camera, x[..., :2], self._white)
        cross = P[..., :2] @ by_place.swapaxes(2, 3)
        spread = by_place @ cross[..., :2, :] + white
        spread[..., (0, 1), (0, 1)] += self._level * self._model.pixel
        residual = np.where(seen[..., None], pixels[None] - predicted, 0.0)
        squared, log_determinant = mahalanobis(residual, spread)
        precision = inverse(spread)
        gain = cross @ precision
        distance = np.sqrt(squared)
        far = distance > TUNING.huber_latency
        cost = (
            np.where(far, TUNING.huber_latency * (2.0 * distance - TUNING.huber_latency), squared)
            + log_determinant
        )
        weight = seen * np.where(
            far, TUNING.huber_latency / np.maximum(distance, TUNING.huber_latency), 1.0
        )
        self._state[:, slots] = x + weight[..., None] * (gain @ residual[..., None])[..., 0]
        self._covariance[:, slots] = P - weight[..., None, None] * (gain @ cross.swapaxes(2, 3))
        lost = seen & (squared > TUNING.lost_squared)
        if lost.any():
            self._begin_anew(camera, slots, pixels, views, lost)
        return LatencyFit(
            np.where(seen, cost, TUNING.out_of_view_cost).mean(axis=1),
            np.minimum(squared, TUNING.most_squared).mean(axis=1),
            log_determinant.mean(axis=1),
            np.einsum("hmij,hmji->hm", precision, white).mean(axis=1),
        )

    def _begin_anew(
        self, camera: CameraModel, slots: list[int], pixels: Array, views: Views, lost: Mask
    ) -> None:
        """Put robots where their boxes are, at some latencies, (h, m) or (h, 1)."""
        state, covariance, shown = self._new(camera, pixels, views)
        lost = lost & shown
        self._state[:, slots] = np.where(lost[..., None], state, self._state[:, slots])
        former = self._covariance[:, slots]
        self._covariance[:, slots] = np.where(lost[..., None, None], covariance, former)

    def _new(self, camera: CameraModel, pixels: Array, views: Views) -> tuple[Array, Array, Mask]:
        """Return state (h, m, 4) and covariance of robots at their boxes, and which are valid."""
        places, shown = views.places(camera, pixels)
        places = np.where(shown[..., None], places, 0.0)
        _, by_place, white, _ = views.measured(camera, places, self._white)
        white[..., (0, 1), (0, 1)] += self._level * self._model.pixel
        precision = by_place.swapaxes(2, 3) @ inverse(white) @ by_place
        state, covariance = np.zeros((*places.shape[:2], 4)), np.zeros((*places.shape[:2], 4, 4))
        state[..., :2] = places
        covariance[..., :2, :2] = inverse(precision)
        covariance[..., (2, 3), (2, 3)] = self._speed**2
        return state, covariance, shown

    def _begin(self, now: BankObservation, names: list[str], views: Views) -> None:
        """Initialise robots at the positions of their boxes, for each latency."""
        pixels = np.array([now.pixels[name] for name in names])
        state, covariance, shown = self._new(now.camera, pixels, views)
        good = np.asarray(shown.all(axis=0))
        self._state = np.concatenate([self._state, state[:, good]], axis=1)
        self._covariance = np.concatenate([self._covariance, covariance[:, good]], axis=1)
        begun = [name for name, ok in zip(names, good, strict=True) if ok]
        self._seen_ns.update(dict.fromkeys(begun, now.stamp_ns))
