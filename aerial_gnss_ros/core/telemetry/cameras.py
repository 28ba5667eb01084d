# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The camera at a time: as messages describe it, or as the parameters do."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.telemetry.corrections import scaled_camera
from aerial_gnss_ros.core.telemetry.series import Series, held_series
from aerial_gnss_ros.core.values.rejection import Reason


@dataclass(frozen=True)
class StampedCamera:
    """A camera's description from a time on; None when the message could not be used."""

    stamp_ns: int
    camera: CameraModel | None


class Cameras:
    """Descriptions of the camera by time; each holds until it is replaced.

    Args:
        config: the camera, where parameters describe it, and the calibrated focal length.
        keep_s: how long descriptions are kept, s.

    Attributes:
        fixed: the camera that the parameters describe, None where messages do.

    Raises:
        CameraError: the camera given as parameters cannot be used.
    """

    def __init__(self, config: EstimatorConfig, keep_s: float = 60.0) -> None:
        self.fixed = camera_of(config)
        self._scale = config.calibration.focal_scale
        self._scaled: tuple[CameraModel, CameraModel] | None = None
        self._series: Series[StampedCamera] = held_series(keep_s=keep_s)
        self._newest: StampedCamera | None = None

    def add(self, stamp_ns: int, camera: CameraModel | None) -> None:
        """Keep a camera; the same one again costs nothing."""
        entry = StampedCamera(stamp_ns, camera)
        latest = self._series.latest(stamp_ns)
        self._newest = entry
        if latest is None or latest.camera is not camera:
            self._series.add(entry)

    def clear(self) -> None:
        """Let the newest camera hold from ever on: time began anew."""
        self._series.clear()
        if self._newest is not None:
            self._series.add(replace(self._newest, stamp_ns=-(2**62)))

    def at(self, stamp_ns: int) -> CameraModel | Reason:
        """Return the newest camera not later than an image, or why there is none."""
        camera = self.fixed
        if camera is None:
            entry = self._series.latest(stamp_ns)
            if entry is None:
                return Reason.NO_CAMERA_INFO
            if entry.camera is None:
                return Reason.BAD_CAMERA_INFO
            camera = entry.camera
        if self._scale == 1.0:
            return camera
        if self._scaled is None or self._scaled[0] is not camera:  # made once for each camera
            self._scaled = camera, scaled_camera(camera, self._scale)
        return self._scaled[1]


def camera_of(config: EstimatorConfig) -> CameraModel | None:
    """Return the camera that the parameters describe, None where CameraInfo does."""
    camera = config.camera
    if camera.source != "parameters":
        return None
    return CameraModel.from_focal_length(
        camera.focal_length_mm * 1e-3,
        camera.sensor_width_mm * 1e-3,
        None if math.isnan(camera.sensor_height_mm) else camera.sensor_height_mm * 1e-3,
        camera.image_width_px,
        camera.image_height_px,
    )
