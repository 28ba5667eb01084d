# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What tests of the estimation share: results of one image."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum, RobotEstimate, State


def result_at(stamp_ns, names=(), boxes=1, state=State.CONFIRMED):
    robots = tuple(
        RobotEstimate(
            stamp_ns, name, "aqua", state, 0.2, -1.0, 0.0, np.zeros(2), np.zeros(2), np.eye(4),
            stamp_ns - 1,
        )
        for name in names
    )  # fmt: skip
    pose = CameraPose(stamp_ns, 0.2, -1.0, 30.0, 30.0, np.eye(3))
    return FrameResult(stamp_ns, "camera", robots, (), MapDatum(0.2, -1.0, 0.0), pose, boxes=boxes)


@pytest.fixture(name="result_at")
def _result_at():
    """Return a function that makes the result of an image with some robots."""
    return result_at
