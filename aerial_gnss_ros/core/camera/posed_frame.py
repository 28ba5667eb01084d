# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One image's boxes with the camera model and pose."""

from __future__ import annotations

from dataclasses import dataclass

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.reference_place import ReferencePlace


@dataclass(frozen=True)
class PosedFrame:
    """One image's boxes with the camera model and pose: all that estimation needs.

    Attributes:
        detections: its boxes.
        camera: lens and image.
        pose: of the camera.
        in_map: the same in the frame `map`.
        latency: correction of `camera.latency_s` contained in the pose, mean and sigma, s; None if
            it is not estimated.
        references: where things of known position are at the time of the scene.
        jumped: East and North by which the receiver has jumped so far, m; empty: it has not.
    """

    detections: DetectionFrame
    camera: CameraModel
    pose: CameraPose
    in_map: MapPose
    latency: tuple[float, float] | None = None
    references: tuple[ReferencePlace, ...] = ()
    jumped: tuple[float, ...] = ()
