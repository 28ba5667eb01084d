# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How far boxes are from where those of the last image would be now, at each of several latencies.

With the right latency a box shows the same place on the water as one of the image before, but for
what robots swim meanwhile; with a wrong one places seem to move with the camera. That needs neither
labels nor tracks: it also tells where a wrong latency leaves nothing that could be tracked.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.filter.latency_views import EXPECTED, Views, by_pose
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.models.measurement_model import level_axes
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.models.platform_model import SLOW, PlatformModel
from aerial_gnss_ros.core.numerics.gaussian import inverse

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ReappearanceTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    most_places: int = 8
    """Greatest number of boxes of an image that are looked for in the next. Judged."""
    apart_s: float = 1.5
    """Boxes of images farther apart are not compared, s. Judged."""
    lasting: float = 9.0
    """Factor of the variances of slow errors, 3 of their sigmas: they are the same in all pairs of
    images, so that one of 2 sigmas would count again in each."""
    elsewhere_squared: float = 15.0
    """Upper bound of a normalised squared distance: beyond, a box shows another place. Judged."""


TUNING = ReappearanceTuning()


class Reappearance:
    """Compares the boxes of successive images at each of h latencies.

    Args:
        model: measurement noise.
        motion: motion model of the robots.
    """

    def __init__(self, model: PlatformModel, motion: MotionModel) -> None:
        self._model, self._speed = model, motion.speed_sigma
        self._slow = TUNING.lasting * model.nominal[SLOW, SLOW]
        self.reset()

    def reset(self) -> None:
        """Forget the last image."""
        self._places: Array | None = None
        self._shown: NDArray[np.bool_] | None = None
        self._views: Views | None = None

    def update(
        self, camera: CameraModel, pixels: Array, passed: float, views: Views
    ) -> tuple[Array, Array] | None:
        """Return how far the last image's boxes are from where they should be seen again.

        None without an image to compare with; else (h,) the mean normalised squared distance beyond
        the expected one, and the mean log determinant of its covariance.

        Args:
            camera: lens and image.
            pixels: (n, 2) centres of this image's boxes.
            passed: time since the last image, s.
            views: the camera at each latency.
        """
        apart = None
        if self._places is not None and 0.0 < passed <= TUNING.apart_s:
            apart = self._apart(camera, pixels, passed, views)
        self._places = self._shown = self._views = None
        if len(pixels):
            self._places, self._shown = views.places(camera, pixels[: TUNING.most_places])
            self._views = views
        return apart

    def _apart(
        self, camera: CameraModel, pixels: Array, passed: float, views: Views
    ) -> tuple[Array, Array]:
        assert self._places is not None  # noqa: S101 - see `update`
        assert self._shown is not None  # noqa: S101
        assert self._views is not None  # noqa: S101
        places = np.where(self._shown[..., None], self._places, 0.0)
        predicted, by_place, noise, ahead = views.measured(camera, places, self._model.white)
        inside = camera.inside(predicted.reshape(-1, 2)).reshape(ahead.shape)
        expected = self._shown & ahead & inside
        # Errors that last show places elsewhere as soon as the camera moves.
        change = by_pose(views.offsets(places)) - by_pose(self._views.offsets(places))
        change[..., 3:] @= level_axes(views.optical[len(views.optical) // 2] @ FLU_FROM_OPTICAL.T)
        elsewhere = change @ self._slow @ change.swapaxes(2, 3)
        elsewhere[..., (0, 1), (0, 1)] += (self._speed * passed) ** 2
        spread = by_place @ elsewhere @ by_place.swapaxes(2, 3) + 2.0 * noise
        spread[..., (0, 1), (0, 1)] += 2.0 * self._model.pixel
        squared = np.full(expected.shape, np.inf)
        if len(pixels):
            apart = pixels - predicted[:, :, None]
            each = np.einsum("hmni,hmij,hmnj->hmn", apart, inverse(spread), apart)
            squared = each.min(axis=2)
        size = spread[..., 0, 0] * spread[..., 1, 1] - spread[..., 0, 1] ** 2
        squared = np.minimum(squared, TUNING.elsewhere_squared)
        # What should be out of view is as far off as what is where it should be.
        mean = np.where(expected, squared - EXPECTED, 0.0).mean(axis=1)
        return np.asarray(mean), np.asarray(np.log(size).mean(axis=1))
