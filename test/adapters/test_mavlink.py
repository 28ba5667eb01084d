# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""GIMBAL_DEVICE_FLAGS: what the angles are relative to."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.adapters import mavlink
from aerial_gnss_ros.core.config.estimator import estimator_config

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
FLAGGED = {
    "gimbal.type": "mavros_gimbal",
    "gimbal.world": "ned",
    "gimbal.body": "frd",
    "gimbal.reference": "mavlink_flags",
}


@pytest.mark.parametrize(
    ("flags", "reference"),
    [
        (64, "earth"),
        (64 | 4 | 8, "earth"),
        (64 | 16, "earth"),
        (32, "heading"),
        (32 | 16, "heading"),  # the frame's own flag counts, not the lock
        (4 | 8 | 32, "heading"),  # what ArduPilot always sends
        (16, "earth"),
        (4 | 8 | 16, "earth"),  # devices from before the frame flags
        (4 | 8, "heading"),
        (0, "heading"),
        (32 | 64, ""),
    ],
)
def test_flags_say_the_reference(flags, reference):
    assert mavlink.reference(flags) == reference
    read = mavlink.gimbal(LEVEL, flags, 7, estimator_config(FLAGGED).gimbal)
    assert read.reference == reference
    assert np.isnan(read.quaternion).all() == (not reference)


def test_a_reference_by_parameter_beats_the_flags():
    config = estimator_config(FLAGGED | {"gimbal.reference": "body"}).gimbal
    for flags in (0, 32, 64, 96):
        read = mavlink.gimbal(LEVEL, flags, 7, config)
        assert read.reference == ""
        np.testing.assert_allclose(np.abs(read.quaternion), LEVEL, atol=1e-15)
