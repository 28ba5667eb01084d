# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The camera from image to image: its pose without jumps of the receiver, and what follows of it.

An image is taken in by two steps, between which the filter follows a jump of the receiver: first
its position is followed, then its pose becomes the view that its boxes are measured by.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.faults.gnss_jump import GnssJumpDetector, nobody
from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.models.camera_motion import TUNING as CAMERA_MOTION
from aerial_gnss_ros.core.models.camera_motion import CameraMotion
from aerial_gnss_ros.core.values.events import Events

Array = NDArray[np.float64]


class CameraTrajectory:
    """Poses of one camera, in the order of time.

    Args:
        latency_s: `camera.latency_s`, which poses contain, s.
        log: receives jumps of the receiver.

    Attributes:
        jumps: detector of GNSS jumps.
        motion: rates of the pose, and jumps of orientation and height.
        passed: time between the last two images, s; 0 at the first.
        view: the last image's camera; None before it.
    """

    def __init__(self, latency_s: float, log: Events) -> None:
        self._latency_ns = round(latency_s * 1e9)
        self.jumps = GnssJumpDetector(log)
        self.reset()

    def reset(self) -> None:
        """Forget all poses."""
        self.jumps.reset()
        self.motion = CameraMotion()
        self.passed = 0.0
        self.view: CameraView | None = None
        self._pose_ns: int | None = None
        self._recalibrated = False

    @property
    def seen_from(self) -> CameraView:
        """The last image's camera, after that image."""
        assert self.view is not None  # noqa: S101 - `look` came first
        return self.view

    def follow_position(
        self, frame: PosedFrame, stated_m: float, robots_tell: Callable[[], bool] = nobody
    ) -> Array | None:
        """Take in an image's position; return the step (3,) to another place of it, m, or None.

        Args:
            frame: the image.
            stated_m: one sigma of the receiver's offset, m.
            robots_tell: tests by robots, on copies of the previous filter, whether its position has
                jumped (see `GnssJumpDetector`).
        """
        stamp_ns = frame.pose.stamp_ns
        passed = 0.0 if self._pose_ns is None else (stamp_ns - self._pose_ns) * 1e-9
        jump = self.jumps.update(frame.jumped, passed, stated_m, robots_tell)
        self._pose_ns, self.passed = stamp_ns, passed
        if jump is not None:
            self.motion.shift(jump)
        return jump

    def look(self, frame: PosedFrame, unsure_s: float) -> None:
        """Take the pose of the image whose position was tested as its view.

        Args:
            frame: the image.
            unsure_s: one sigma of an unknown latency, s; 0: it is known.
        """
        pose, measured = frame.pose, frame.in_map
        shown = MapPose(measured.position - self.jumps.offset, measured.rotation)
        applied = (frame.detections.stamp_ns - pose.stamp_ns - self._latency_ns) * 1e-9
        elsewhen = self._recalibrated or (
            self.view is not None and abs(applied - self.view.applied) > CAMERA_MOTION.moved_s
        )
        self._recalibrated = False
        motion = self.motion
        foretold = motion.restart(shown) if elsewhen else motion.update(shown, self.passed)
        noise = pose.interpolation_noise(self.passed)
        self.view = CameraView.of(
            frame.camera, shown, motion.rates, applied, foretold, unsure_s, noise
        )

    def delay(self, seconds: float, searched: bool) -> None:
        """Let poses contain a larger `camera.latency_s` from now on.

        Args:
            seconds: by how much it is larger, s.
            searched: whether the latency is estimated by `LatencySearch`, so that poses stay.
        """
        later_ns = round(seconds * 1e9)
        self._latency_ns += later_ns
        if self._pose_ns is not None and not searched:
            self._pose_ns -= later_ns

    def note_recalibration(self) -> None:
        """Note that the next pose has another calibration: its motion from the last is none."""
        self._recalibrated = True
