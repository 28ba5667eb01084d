# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Detects a frozen image while the camera moves, or telemetry that freezes in motion.

Both come with new stamps, so nothing else reveals them. Repetition alone is no fault: gimbals hold
still, logs are rounded. But an image cannot stay equal to the last bit while the camera moves, nor
all telemetry during a motion.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geometry.geodesy import on_water_surface
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.models.measurement_model import on_water
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FrozenInputTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    picture_s: float = 0.3
    """Time for which boxes may repeat, s: videos duplicate single frames. Judged."""
    picture_sigmas: float = 1.5
    """Least motion of boxes expected without freezing, in sigmas of a box's centre. Judged."""
    telemetry_s: float = 1.0
    """Time for which telemetry may repeat, s. Judged."""
    moving_images: int = 5
    """Number of preceding images with the drone in motion, see `speed_mps`. Judged."""
    speed_mps: float = 1.0
    """Median speed above which it counts as in motion, m/s: a drone does not stop within an image;
    a gimbal may. Judged."""
    jitter_m: float = 1e-3
    """Noise of a real receiver, median second difference from image to image, m: with it no
    position stays the same to the last bit. A simulator's may. Judged."""


TUNING = FrozenInputTuning()


@dataclass(frozen=True)
class _Shown:
    """An image's boxes and the camera's pose.

    Attributes:
        stamp_ns: of the image.
        frame: its boxes.
        pose: of the camera.
    """

    stamp_ns: int
    frame: DetectionFrame
    pose: MapPose

    @property
    def boxes(self) -> Array:
        """(n, 5) centre, size, score."""
        return np.column_stack([self.frame.centers, self.frame.sizes, self.frame.scores])


class FrozenInputDetector:
    """Tests consecutive images.

    Args:
        pixel_sigma: one sigma of a box's centre, px.
    """

    def __init__(self, pixel_sigma: float) -> None:
        self._shift_px = TUNING.picture_sigmas * pixel_sigma
        self.reset()

    def reset(self) -> None:
        """Clear all images."""
        self._first: _Shown | None = None
        self._stands = False
        self._poses: deque[tuple[int, MapPose]] = deque(maxlen=TUNING.moving_images + 1)
        self._moved = False

    def recalibrate(self) -> None:
        """Compare no image with one before another calibration, which moves the camera."""
        self._first, self._stands = None, False

    def image_frozen(self, frame: DetectionFrame, camera: CameraModel, pose: MapPose) -> bool:
        """Update with an image's boxes; return whether the image is frozen while the camera moves.

        Args:
            frame: all usable boxes.
            camera: lens and image size.
            pose: of the camera.
        """
        first = self._first
        if first is None or not len(frame.centers) or not _equal(first.frame, frame):
            self._first, self._stands = _Shown(frame.stamp_ns, frame, pose), False
            return False
        if self._stands or frame.stamp_ns - first.stamp_ns <= TUNING.picture_s * 1e9:
            return self._stands
        self._stands = _shift_px(first, camera, pose) > self._shift_px
        return self._stands

    def telemetry_frozen(self, stamp_ns: int, pose: MapPose) -> bool:
        """Update with a pose; return whether telemetry has frozen during a motion.

        Args:
            stamp_ns: of the scene.
            pose: of the camera.
        """
        poses = self._poses
        last = poses[-1][1] if poses else None
        if last is None or not (
            last.position.tolist() == pose.position.tolist()
            and np.array_equal(last.rotation, pose.rotation)
        ):
            poses.append((stamp_ns, pose))
            self._moved = False
            return False
        if stamp_ns - poses[-1][0] <= TUNING.telemetry_s * 1e9:
            return False
        self._moved = self._moved or _in_motion(list(poses))
        return self._moved


def _equal(one: DetectionFrame, other: DetectionFrame) -> bool:
    """Return whether two images have the same boxes, to the last bit."""
    return (
        len(one.centers) == len(other.centers)
        and one.centers[0].tolist() == other.centers[0].tolist()  # nearly always differs
        and one.centers.tolist() == other.centers.tolist()
        and one.sizes.tolist() == other.sizes.tolist()
        and one.scores.tolist() == other.scores.tolist()
    )


def _in_motion(poses: list[tuple[int, MapPose]]) -> bool:
    """Return whether the drone flew from image to image, by a sensor with noise.

    One jump is no motion.
    """
    if len(poses) <= TUNING.moving_images:
        return False
    times = np.array([stamp_ns for stamp_ns, _ in poses]) * 1e-9
    steps = np.diff([pose.position for _, pose in poses], axis=0)
    speeds = np.linalg.norm(steps, axis=1) / np.maximum(np.diff(times), 1e-3)
    jitter = np.linalg.norm(np.diff(steps, axis=0), axis=1)
    return bool(np.median(speeds) >= TUNING.speed_mps and np.median(jitter) >= TUNING.jitter_m)


def _shift_px(first: _Shown, camera: CameraModel, pose: MapPose) -> float:
    """Return the greatest motion of boxes of objects at rest since an image, px."""
    rays, inside = camera.rays(first.boxes[_numbers(first.boxes), :2])
    places = on_water(first.pose, rays[inside] @ (first.pose.rotation @ FLU_FROM_OPTICAL).T)
    places = places[np.isfinite(places).all(axis=1)]
    before, _ = camera.project(
        (on_water_surface(places) - first.pose.position) @ first.pose.optical
    )
    now, seen = camera.project((on_water_surface(places) - pose.position) @ pose.optical)
    if not len(places):
        return 0.0
    if not seen.all():
        return math.inf
    return float(np.max(np.hypot(*(now - before).T)))


def _numbers(boxes: Array) -> NDArray[np.bool_]:
    """Return which boxes (n, 5) are finite."""
    return np.asarray(np.isfinite(boxes).all(axis=1))
