# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images with boxes whose camera's pose is known."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.faults.image_orientation import PosedBoxes
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.preflight.flight_state import STEP_NS

_MOST = 18_000
"""Number of images kept."""
_WAITING = 600
"""Number of images that wait for telemetry: more come in while none does."""


class PosedImages:
    """Keeps images with boxes, `STEP_NS` apart at least, once telemetry of their scene is there.

    Args:
        latency_ns: of the images, ns.

    Attributes:
        images: in the order of time.
    """

    def __init__(self, latency_ns: int) -> None:
        self.images: deque[PosedBoxes] = deque(maxlen=_MOST)
        self._latency_ns = latency_ns
        self._waiting: deque[DetectionFrame] = deque(maxlen=_WAITING)

    def add(self, frame: DetectionFrame) -> None:
        """Let an image wait, unless it follows the last one too closely."""
        newest = self._waiting[-1] if self._waiting else None
        if len(frame.centers) and (newest is None or frame.stamp_ns - newest.stamp_ns >= STEP_NS):
            self._waiting.append(frame)

    def clear(self) -> None:
        """Forget all images: their time is another one."""
        self.images.clear()
        self._waiting.clear()

    def settle(
        self, camera: CameraModel | None, pose_at: Callable[[int], CameraPose | bool]
    ) -> None:
        """Take in images whose telemetry has come.

        Args:
            camera: lens and image; None: unknown.
            pose_at: returns the camera's pose at a time, ns, else whether it may still come.
        """
        while camera is not None and self._waiting:
            pose = pose_at(self._waiting[0].stamp_ns - self._latency_ns)
            if pose is True:
                return
            frame = self._waiting.popleft()
            if isinstance(pose, CameraPose):
                self.images.append(PosedBoxes(pose, camera, frame.centers))
