# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A bank of Kalman filters, one for each candidate latency, with the fit of the boxes to each.

With the right latency robots stay or move smoothly; with a wrong one they seem to move with the
drone. What the platform's errors have in common for all robots says nothing of the latency, so each
filter estimates them together with the robots (position and velocity in `map`, an extended Kalman
filter on pixels).

Nobody knows how large and how lasting errors are, and what was stated may be wrong by a factor. So
each candidate has a filter for each of a few hypotheses of the noise (`HYPOTHESES`), and its fit is
the likelihood of the mixture of these, each weighed by how well it predicted the images so far.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.filter.bank_state import COMMON, BankState, ShownPlaces
from aerial_gnss_ros.core.filter.correlation_times import TUNING as CORRELATION_TIMES
from aerial_gnss_ros.core.filter.latency_views import EXPECTED, Mask, Views, by_pose
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.models.measurement_model import level_axes
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import SLOW, PlatformModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LatencyBankTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    most_robots: int = 4
    """Greatest number of robots: more add little, as their common errors are the platform's.
    Judged."""
    forget_s: float = 2.0
    """A robot unseen for longer is initialised again, s. Judged."""
    noisier: float = 9.0
    """Factor of variances by which they may be larger or smaller than stated: 3 of standard
    deviations."""
    turns: float = 0.2
    """Acceleration of robots where they turn, root of its spectral density, m/s^1.5. Judged."""
    box_lasts_s: float = 1.5
    """Correlation time of boxes' errors where these last, s: a detector that takes foam or a wake
    for a part of the robot. Judged."""
    box_white: float = 0.02
    """Share of a box's variance that is white in any case: boxes are rounded. Judged."""
    degrees: float = 4.0
    """Degrees of freedom of Student's t distribution of a box's residual: as heavy tails as have a
    variance. Judged."""
    out_of_view_cost: float = 30.0
    """Cost of a latency that puts a detected robot out of view. Judged."""
    lost_squared: float = 40.0
    """Normalised squared residual from which a robot begins anew at its box: what jumped, or began
    to turn by itself, costs once, and at all latencies alike. Judged."""


TUNING = LatencyBankTuning()


class NoiseHypothesis(NamedTuple):
    """What errors may be like.

    Attributes:
        level: ratio of the variances of all errors to the stated ones.
        lasts_s: correlation time of the platform's slow errors, s; None: as stated.
        box_lasts_s: correlation time of boxes' errors, s; 0: they are white.
        turns: acceleration of robots beyond their class's, root of its spectral density, m/s^1.5.
    """

    level: float = 1.0
    lasts_s: float | None = None
    box_lasts_s: float = 0.0
    turns: float = 0.0


HYPOTHESES = (
    NoiseHypothesis(1.0 / TUNING.noisier),
    NoiseHypothesis(),
    NoiseHypothesis(TUNING.noisier),
    NoiseHypothesis(1.0, CORRELATION_TIMES.quick_s),
    NoiseHypothesis(TUNING.noisier, CORRELATION_TIMES.quick_s),
    NoiseHypothesis(box_lasts_s=TUNING.box_lasts_s),
    NoiseHypothesis(turns=TUNING.turns),
)
"""As likely as one another before any image."""


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
    """Fit of one image's boxes to each of h latencies, summed over robots.

    The -2 log likelihood is the sum of misfit and size, up to a constant.

    Attributes:
        misfit: (h,) what residuals in units of their noise cost beyond what is expected.
        size: (h,) mean log determinant of the residuals' covariances.
        count: number of robots.
    """

    misfit: Array
    size: Array
    count: int

    @property
    def of_a_robot(self) -> tuple[Array, Array]:
        """Misfit and size (h,) in the mean over robots: errors of telemetry are common to them."""
        return self.misfit / self.count, self.size / self.count


Shown = Callable[[str], ShownPlaces]
"""Where the box of a robot shows it."""


class LatencyBank:
    """Tracks robots at each of h candidate latencies, under each hypothesis of the noise.

    Args:
        model: measurement noise and platform errors.
        motion: motion model of the robots.
        count: h.
    """

    def __init__(self, model: PlatformModel, motion: MotionModel, count: int) -> None:
        self._model, self._motion, self._count = model, motion, count
        stated_s = model.correlation_time_s
        lasts = [stated_s if one.lasts_s is None else one.lasts_s for one in HYPOTHESES]
        # Gaussian i is of latency i // k and hypothesis i % k.
        self._level = np.tile([one.level for one in HYPOTHESES], count)
        self._lasts_s = np.tile(lasts, count)
        self._box_lasts_s = np.tile([one.box_lasts_s for one in HYPOTHESES], count)
        self._box = self._level * model.pixel
        turns = np.tile([one.turns for one in HYPOTHESES], count)
        self._acceleration: Array = np.hypot(motion.acceleration, turns)
        self.reset()

    def reset(self) -> None:
        """Forget all robots."""
        self._seen_ns: dict[str, int] = {}  # in the order of the robots in the state
        # A tuple: a snapshot shares what it holds, so an image is taken in by a copy.
        self._state: tuple[BankState, ...] = ()
        self._odds: Array = np.zeros((self._count, len(HYPOTHESES)))

    def places(self) -> dict[str, Array]:
        """Return where (h, 2) each latency has robots, by name, m: the mean of its hypotheses."""
        if not self._state:
            return {}
        share = np.exp(_normalised(self._odds))[..., None, None]
        robots = self._state[0].robots[..., :2]
        means = (share * robots.reshape(*self._odds.shape, -1, 2)).sum(axis=1)
        return {name: means[:, slot] for slot, name in enumerate(self._seen_ns)}

    def update(
        self,
        now: BankObservation,
        passed: float,
        positions: Array,
        rotations: Array,
        anew: Mask | None = None,
        interpolation: Array | None = None,
    ) -> LatencyFit | None:
        """Update with an image; return its fit, None if no robot was known before.

        Args:
            now: the boxes.
            passed: time since the previous image, s.
            positions: (h, 3) of the camera for each latency, m.
            rotations: (h, 3, 3) camera FLU in `map`.
            anew: (h,) whether robots begin anew at their boxes; None: none do.
            interpolation: (h, 6) variances of the poses, see `Views`.
        """
        platform = self._level[:, None, None] * self._slow(now.fix_covariance)
        each, speed = len(HYPOTHESES), self._motion.speed_sigma
        state = copy.deepcopy(self._state[0]) if self._state else BankState(platform, speed)
        self._forget(now.stamp_ns, state)
        if passed > 0.0:
            keep = _kept(passed, self._lasts_s)
            state.predict(passed, keep, platform, self._acceleration)
        white = self._level[:, None] * self._model.white
        if interpolation is not None:
            white = white + self._level[:, None] * np.repeat(interpolation, each, axis=0)
        state.begin_image(white, _kept(passed, self._box_lasts_s), self._box)
        optical = rotations @ FLU_FROM_OPTICAL
        views = Views(np.repeat(positions, each, axis=0), np.repeat(optical, each, axis=0))
        axes = level_axes(rotations[len(rotations) // 2])
        shown = partial(self._shown, now, Views(positions, optical), axes)
        names = list(self._seen_ns)
        known = {name: names.index(name) for name in names if name in now.pixels}
        fit = self._correct(state, now, known, shown, views, axes) if known else None
        if anew is not None and anew.any():
            begins = np.repeat(anew, each)
            state.forget(begins, platform)
            for name, slot in known.items():
                state.restart(slot, shown(name), begins)
        self._seen_ns.update(dict.fromkeys(known, now.stamp_ns))
        self._begin(now, shown, state)
        state.symmetrise()
        self._state = (state,)
        return fit

    def _slow(self, fix_covariance: Array | None) -> Array:
        """Return the (6, 6) stated covariance of the platform's slow errors."""
        return self._model.stationary(fix_covariance)[SLOW, SLOW]

    def _forget(self, stamp_ns: int, state: BankState) -> None:
        since = [stamp_ns - seen for seen in self._seen_ns.values()]
        kept = [i for i, unseen in enumerate(since) if unseen <= TUNING.forget_s * 1e9]
        if len(kept) < len(since):
            names = list(self._seen_ns)
            self._seen_ns = {names[i]: self._seen_ns[names[i]] for i in kept}
            state.keep(kept)

    def _begin(self, now: BankObservation, shown: Shown, state: BankState) -> None:
        """Begin with robots that were not known, where their boxes show water at all latencies."""
        fresh = [name for name in now.pixels if name not in self._seen_ns]
        for name in fresh[: TUNING.most_robots - len(self._seen_ns)]:
            place = shown(name)
            if place.valid.all():
                state.add(place)
                self._seen_ns[name] = now.stamp_ns

    def _shown(self, now: BankObservation, views: Views, axes: Array, name: str) -> ShownPlaces:
        """Return where a robot's box shows it, which is the same under each hypothesis."""
        places, valid = views.places(now.camera, now.pixels[name][None])
        places = np.where(valid[..., None], places, 0.0)
        moved = by_pose(views.offsets(places))[:, 0]
        _, by_place, _, _ = views.projected(now.camera, places)
        of_latency = places[:, 0], _common(moved, axes), np.linalg.pinv(by_place[:, 0]), valid[:, 0]
        place, by_common, by_box, shows = (
            np.repeat(one, len(HYPOTHESES), axis=0) for one in of_latency
        )
        return ShownPlaces(place, by_common, by_box, self._box, shows)

    def _correct(
        self, state: BankState, now: BankObservation, known: dict[str, int], shown: Shown,
        views: Views, axes: Array,
    ) -> LatencyFit:  # fmt: skip
        """Take in the boxes of known robots, given by their slots."""
        slots = list(known.values())
        robots = state.robots[:, slots]
        pixels, by_place, moved, seen = views.projected(now.camera, robots[..., :2])
        by_common = _common(moved, axes)
        expected = pixels + robots[..., 4:]
        expected += (by_common @ state.mean[:, None, :COMMON, None])[..., 0]
        residuals = np.array([now.pixels[name] for name in known]) - expected
        noise = TUNING.box_white * self._box
        given = residuals, seen, by_common, by_place, noise, TUNING.degrees
        fit = state.correct(slots, *given)
        costs = (TUNING.degrees + 2.0) * np.log1p(fit.squared / TUNING.degrees) - EXPECTED
        misfit = np.where(seen, costs, TUNING.out_of_view_cost).sum(axis=1)
        size = np.log(fit.determinants).sum(axis=1)
        lost = seen & (fit.squared > TUNING.lost_squared)
        for i, (name, slot) in enumerate(known.items()):
            if lost[:, i].any():
                state.restart(slot, shown(name), lost[:, i])
        return self._mixed(misfit, size, len(known))

    def _mixed(self, misfit: Array, size: Array, count: int) -> LatencyFit:
        """Return the fit of the mixture of hypotheses, and weigh these by the image."""
        misfit, size = misfit.reshape(self._odds.shape), size.reshape(self._odds.shape)
        likelihood = -0.5 * (misfit + size)
        share = _normalised(self._odds)
        self._odds = share + likelihood
        cost = -2.0 * np.logaddexp.reduce(self._odds, axis=1)
        mean_size = np.sum(np.exp(_normalised(self._odds)) * size, axis=1)
        return LatencyFit(cost - mean_size, mean_size, count)


def _kept(seconds: float, lasts_s: Array) -> Array:
    """Return by what errors that last so long decay over a time; 0: they are white."""
    kept: Array = np.exp(-seconds / np.maximum(lasts_s, 1e-9))
    return np.where(lasts_s > 0.0, kept, 0.0)


def _normalised(odds: Array) -> Array:
    """Return the log probabilities (h, k) of odds."""
    return np.asarray(odds - np.logaddexp.reduce(odds, axis=1, keepdims=True))


def _common(by_white: Array, axes: Array) -> Array:
    """Return the derivative (…, 2, 12) by slow errors and white noise from that by the noise."""
    by_slow = by_white.copy()
    by_slow[..., 3:] = by_white[..., 3:] @ axes
    return np.concatenate([by_slow, by_white], axis=-1)
