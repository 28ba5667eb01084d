# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tells from boxes whether the image is turned or mirrored against its camera's pose.

A camera that is mounted upside down, or whose driver flips the image, puts robots at the wrong side
of the image centre: from an orbit around them metres off, from a flight past them tens of metres.

What floats hardly moves. So where a box is in one image tells where it must be in another one a
second away, by the poses of both. If the image is turned or mirrored, that holds for the pixels
turned back. On an orbit around the image centre an image that is turned by 180 deg looks the same:
there nothing tells it. Robots that swim may by chance go as they would in a turned image; only what
is faster than they can be is sure.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic
from aerial_gnss_ros.core.values.camera_pose import CameraPose

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ImageOrientationTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    least_s: float = 0.5
    """Least time between images, s. Judged."""
    pair_s: float = 2.0
    """Greatest time between the two images of a pair, s: much flight, and little motion of what
    floats. Judged."""
    least_pairs: int = 10
    """Least number of pairs. Judged."""
    judged_pairs: int = 60
    """Number of pairs by which it is judged: of half a minute. Judged."""
    least_flow: float = 0.02
    """Least distance by which the worst way misses boxes, of the image's width; noise of boxes and
    poses is a fifth of it. Judged."""
    sure_ratio: float = 3.0
    """Least ratio of the distances of two ways by which a pair tells one. Judged."""
    sure_share: float = 0.8
    """Least share of the pairs that tell it: false boxes tell any, each a few. Judged."""


TUNING = ImageOrientationTuning()

WAYS: dict[str, Array] = {
    "": np.array([[1.0, 0.0], [0.0, 1.0]]),
    "turned by 180 deg": np.array([[-1.0, 0.0], [0.0, -1.0]]),
    "turned by 90 deg clockwise": np.array([[0.0, 1.0], [-1.0, 0.0]]),
    "turned by 90 deg counter-clockwise": np.array([[0.0, -1.0], [1.0, 0.0]]),
    "mirrored left to right": np.array([[-1.0, 0.0], [0.0, 1.0]]),
    "mirrored top to bottom": np.array([[1.0, 0.0], [0.0, -1.0]]),
}
"""Maps of a turned image's pixels, from its middle, to those of the camera that the pose is of."""


@dataclass(frozen=True)
class PosedBoxes:
    """Boxes of an image, and where its camera was.

    Attributes:
        pose: of the camera.
        camera: lens and image.
        centers: (n, 2) px.
    """

    pose: CameraPose
    camera: CameraModel
    centers: Array


class ImageOrientation:
    """Judges pairs of images.

    Attributes:
        way: how the image is turned; empty if it is not, None if boxes do not tell.
        missed: by how much boxes miss where they should be if it is as the pose says, and if it is
            as the best other way says, in image widths; NaN without enough pairs.
        speed: at which things must move if it is as the pose says, m/s; NaN without enough pairs.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all images."""
        self.way: str | None = None
        self.missed = np.nan, np.nan
        self.speed = np.nan
        self._images: deque[PosedBoxes] = deque()
        self._misses: deque[Array] = deque(maxlen=TUNING.judged_pairs)

    def update(self, image: PosedBoxes) -> None:
        """Update with an image; one soon after the last one, or without boxes, is left out."""
        images, now_ns = self._images, image.pose.stamp_ns
        while images and not 0 <= now_ns - images[0].pose.stamp_ns <= TUNING.pair_s * 1e9:
            images.popleft()
        soon = images and now_ns - images[-1].pose.stamp_ns < TUNING.least_s * 1e9
        if soon or not len(image.centers):
            return
        if images:
            self._misses.append(_missed(images[0], image))
            self._judge()
        images.append(image)

    def _judge(self) -> None:
        every, speeds = np.split(np.array(self._misses), [len(WAYS)], axis=1)
        known = np.isfinite(every)
        enough = known.sum(axis=0) >= TUNING.least_pairs
        if not enough[0]:
            return
        medians = np.full(len(WAYS), np.inf)
        medians[enough] = np.nanmedian(every[:, enough], axis=0)
        best = 1 + int(np.argmin(medians[1:]))
        self.missed = float(medians[0]), float(medians[best])
        self.speed = float(np.nanmedian(speeds)) if np.isfinite(speeds).any() else np.nan
        every[~known] = np.inf
        right, others = TUNING.sure_ratio * every[:, 0], every[:, 1:].min(axis=1)
        self.way = None
        if medians[enough].max() < TUNING.least_flow:
            return
        if np.mean(right < others) >= TUNING.sure_share:
            self.way = ""
        elif np.mean(TUNING.sure_ratio * every[:, best] < every[:, 0]) >= TUNING.sure_share:
            self.way = [*WAYS][best]


def judged(images: Sequence[PosedBoxes]) -> ImageOrientation:
    """Return what images say, in the order of time."""
    found = ImageOrientation()
    for image in images:
        found.update(image)
    return found


def _missed(one: PosedBoxes, other: PosedBoxes) -> Array:
    """Return by how much boxes miss where they must be, in image widths, and their speed, m/s.

    (ways + 1,), NaN where it is unknown; the speed is of what they are if nothing is turned.
    """
    found = np.full(len(WAYS) + 1, np.nan)
    step = _step(one, other)
    to_camera = other.pose.enu_from_camera @ FLU_FROM_OPTICAL
    for k, turned in enumerate(WAYS.values()):
        places = _places(one, turned) - step
        pixels, shown = other.camera.project(places @ to_camera)
        if shown.any():
            found[k] = _nearest(pixels[shown], _turned(other, turned)) / other.camera.width
    upright = WAYS[""]
    places, later = _places(one, upright) - step, _places(other, upright)
    if len(places) and len(later):
        passed_s = (other.pose.stamp_ns - one.pose.stamp_ns) * 1e-9
        found[-1] = _nearest(places, later) / passed_s
    return found


def _nearest(expected: Array, seen: Array) -> float:
    """Return the median distance from points (m, d) to the nearest of others (n, d)."""
    apart = np.linalg.norm(expected[:, None] - seen, axis=2).min(axis=1)
    return float(np.median(apart))


def _turned(image: PosedBoxes, turned: Array) -> Array:
    middle = 0.5 * np.array([image.camera.width - 1.0, image.camera.height - 1.0])
    pixels: Array = middle + (image.centers - middle) @ turned.T
    return pixels


def _places(image: PosedBoxes, turned: Array) -> Array:
    """Return where boxes (m, 3) are on the water, East, North, Up from the camera, m."""
    rays, valid = image.camera.rays(_turned(image, turned))
    directions = rays @ FLU_FROM_OPTICAL.T @ image.pose.enu_from_camera.T
    valid &= directions[:, 2] < 0.0
    directions = directions[valid]
    found: Array = directions * (image.pose.height / -directions[:, 2:])
    return found


def _step(one: PosedBoxes, other: PosedBoxes) -> Array:
    """Return the way (3,) from the camera of an image to that of another one, m."""
    step = enu_from_geodetic(
        other.pose.latitude, other.pose.longitude, 0.0, one.pose.latitude, one.pose.longitude, 0.0
    )
    step[2] = other.pose.height - one.pose.height
    return step
