# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The camera model at a time, from messages or parameters."""

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
    """A camera model valid from a time on; None if the message was unusable."""

    stamp_ns: int
    camera: CameraModel | None


class Cameras:
    """Camera models by time; each is valid until replaced.

    Args:
        config: the camera if given by parameters, and the calibrated focal length.
        keep_s: time for which models are kept, s.

    Attributes:
        fixed: the camera given by parameters, or None.

    Raises:
        CameraError: the camera given by parameters is unusable.
    """

    def __init__(self, config: EstimatorConfig, keep_s: float = 60.0) -> None:
        self.fixed = camera_of(config)
        self._scale = config.calibration.focal_scale
        self._scaled: tuple[CameraModel, CameraModel] | None = None
        self._series: Series[StampedCamera] = held_series(keep_s=keep_s)
        self._newest: StampedCamera | None = None

    def rescale(self, scale: float) -> None:
        """Use another ratio of the true focal length to the stated one."""
        self._scale, self._scaled = scale, None

    def add(self, stamp_ns: int, camera: CameraModel | None) -> None:
        """Store a camera; repetitions cost nothing."""
        entry = StampedCamera(stamp_ns, camera)
        latest = self._series.latest(stamp_ns)
        self._newest = entry
        if latest is None or latest.camera is not camera:
            self._series.add(entry)

    def clear(self) -> None:
        """Make the newest camera valid from any time on, after a reset of time."""
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
    """Return the camera given by parameters, None if CameraInfo is used."""
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
