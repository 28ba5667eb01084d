# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The camera's orientation from TF (`gimbal.source: tf`), read from its topics without tf2.

REP 103: bodies have axes forward, left, up; frames whose name ends with `_optical` or
`_optical_frame` have right, down, forward.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.core.config.telemetry import GimbalConfig
from aerial_gnss_ros.core.geometry.frames import (
    FLU_FROM_OPTICAL,
    quaternion_from_matrix,
    quaternion_product,
)
from aerial_gnss_ros.core.telemetry.frame_tree import FrameTree
from aerial_gnss_ros.core.values.samples import Orientation

GRACE_NS = 2_000_000_000
"""Time after the first message in which a missing transform may still arrive, ns."""
REPEAT_NS = 1_000_000_000
"""Least time between two reports of one trouble, ns."""
OPTICAL = ("_optical", "_optical_frame")

_OPTICAL_FROM_FLU = quaternion_from_matrix(FLU_FROM_OPTICAL.T)


class TfGimbal:
    """Orientations of the camera in the base frame.

    Args:
        config: names the frames.
    """

    def __init__(self, config: GimbalConfig) -> None:
        self._tree = FrameTree(config.base_frame, config.camera_frame, config.max_gap)
        self._on_arrival = config.stamp == "arrival"
        self._optical = is_optical(config)
        self._frames = f"gimbal.base_frame {config.base_frame}, camera_frame {config.camera_frame}"
        self._first_ns: int | None = None
        self._reported_ns: int | None = None

    def add(self, msg: Any, arrival_ns: int, static: bool) -> list[Orientation]:
        """Take a tf2_msgs/TFMessage; return the orientations of the camera known since.

        Args:
            msg: with transforms.
            arrival_ns: when it arrived, ns.
            static: whether it came on /tf_static.
        """
        for one in msg.transforms:
            stamp = arrival_ns if self._on_arrival else nanoseconds(one.header.stamp)
            q = one.transform.rotation
            turn = Orientation(stamp, np.array([q.x, q.y, q.z, q.w], dtype=np.float64))
            parent, child = (
                str(name).lstrip("/") for name in (one.header.frame_id, one.child_frame_id)
            )
            self._tree.add(parent, child, turn, static, arrival_ns)
        return [self._camera(one) for one in self._tree.ready()]

    def static(self, stamp_ns: int) -> Orientation | None:
        """Return the orientation of a camera fixed to the base, None if it moves."""
        found = self._tree.static(stamp_ns)
        return None if found is None else self._camera(found)

    def trouble(self, arrival_ns: int) -> str:
        """Return why there is no orientation, once a second; empty if there is one.

        Args:
            arrival_ns: when the last message arrived, ns.
        """
        if self._first_ns is None or arrival_ns < self._first_ns:
            self._first_ns, self._reported_ns = arrival_ns, None
        if arrival_ns - self._first_ns < GRACE_NS:
            return ""
        last_ns = self._reported_ns
        trouble = self._tree.trouble(arrival_ns)
        if not trouble or (last_ns is not None and arrival_ns - last_ns < REPEAT_NS):
            return ""
        self._reported_ns = arrival_ns
        return f"{trouble} ({self._frames})"

    def _camera(self, turn: Orientation) -> Orientation:
        """Return the orientation of the camera's forward, left, up."""
        if not self._optical:
            return turn
        return Orientation(turn.stamp_ns, quaternion_product(turn.quaternion, _OPTICAL_FROM_FLU))


def is_optical(config: GimbalConfig) -> bool:
    """Return whether the camera's frame has the axes right, down, forward."""
    if config.camera_axes == "suffix":
        return config.camera_frame.endswith(OPTICAL)
    return config.camera_axes == "optical"
