# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Collects all telemetry and boxes of a replay for a calibration."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.georeferencing import detection_filter
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.pose import PoseBuilder
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum
from aerial_gnss_ros.core.values.rejection import Input, Reason
from aerial_gnss_ros.core.values.samples import Array, Fix, Orientation, Scalar

WHOLE_FLIGHT_S = 1e6


class Recording(Estimator):
    """An estimator that only records its inputs: drive it through a replay.

    Args:
        config: the estimator's parameters; its corrections are applied to all poses.

    Attributes:
        config: the parameters.
        frames: the accepted boxes of each image, by its stamp.
        stamps: of the samples received, by input, ns.
    """

    def __init__(self, config: EstimatorConfig) -> None:
        self.config = replace(config, state_file="")
        super().__init__(self.config)
        self.frames: dict[int, DetectionFrame] = {}
        self.stamps: dict[Input, list[int]] = {source: [] for source in Input}
        self._all = TelemetryBuffers(self.config, WHOLE_FLIGHT_S)
        self._camera_stamps: list[int] = []
        self._posing = PoseBuilder(self.config)
        bare = replace(self.config.camera, offset_m=(0.0, 0.0, 0.0))
        self._antenna = PoseBuilder(replace(self.config, camera=bare))
        self._first_fix: Fix | None = self._all.constant_fix
        self._local: LocalMap | None = None

    def add_fix(self, fix: Fix) -> None:
        """Add a position of the drone."""
        super().add_fix(fix)
        self._remember(Input.FIX, fix)

    def add_attitude(self, attitude: Orientation) -> None:
        """Add an orientation of the body."""
        super().add_attitude(attitude)
        self._remember(Input.ATTITUDE, attitude)

    def add_gimbal(self, gimbal: Orientation) -> None:
        """Add an orientation of the camera."""
        super().add_gimbal(gimbal)
        self._remember(Input.GIMBAL, gimbal)

    def add_height(self, height: Scalar) -> None:
        """Add a height of the drone."""
        super().add_height(height)
        self._remember(Input.HEIGHT, height)

    def add_water_level(self, level: Scalar) -> None:
        """Add a water level."""
        super().add_water_level(level)
        self._all.add_level(level)

    def add_depth(self, class_id: str, depth: Scalar) -> None:
        """Add a depth that robots of a class send."""
        super().add_depth(class_id, depth)
        self._all.depths.add(class_id, depth)

    def add_camera(self, stamp_ns: int, camera: CameraModel | None) -> None:
        """Add the camera model."""
        super().add_camera(stamp_ns, camera)
        self._all.cameras.add(stamp_ns, camera)

    def add_detections(self, frame: DetectionFrame) -> None:
        """Add one image's boxes."""
        wanted = self.config.detections
        reasons = detection_filter.refusals(frame, wanted.min_score, wanted.classes)
        self.frames[frame.stamp_ns] = frame.keep(np.array([one is None for one in reasons], bool))

    def advance(self, _now_ns: int, _steady_ns: int | None = None) -> list[FrameResult]:
        """Return nothing: a calibration uses the recording as a whole."""
        return []

    def flush(self) -> list[FrameResult]:
        """Return nothing."""
        return []

    def camera(self, stamp_ns: int) -> CameraModel | None:
        """Return the camera model of an image; None if it is unknown."""
        found = self._all.cameras.at(stamp_ns)
        return None if isinstance(found, Reason) else found

    def depths(self, frame: DetectionFrame) -> Array:
        """Return the depths (n,) of an image's robots below the surface, m."""
        found = self._all.depths.at(frame.class_ids, frame.stamp_ns)
        return np.zeros(len(frame)) if found is None else found

    def pose(self, scene_ns: int, at_antenna: bool = False) -> MapPose | None:
        """Return the camera in `map` at the time of a scene; None without telemetry.

        Args:
            scene_ns: time.
            at_antenna: the position of the GNSS antenna instead of the camera's.
        """
        if self._first_fix is None:
            return None
        if self._local is None:
            first = self._first_fix
            self._local = LocalMap(MapDatum(first.latitude, first.longitude, 0.0))
        samples = self._all.at(scene_ns)
        if isinstance(samples, MissingTelemetry):
            return None
        pose = (self._antenna if at_antenna else self._posing).pose(samples)
        return None if isinstance(pose, Reason) else MapPose.of(pose, self._local)

    def _remember(self, source: Input, value: Fix | Orientation | Scalar) -> None:
        trouble = self._all.add(source, value)
        if not trouble:
            self.stamps[source].append(value.stamp_ns)
            if self._first_fix is None and isinstance(value, Fix):
                self._first_fix = value
