# SPDX-License-Identifier: Apache-2.0
"""Orientations whose stamps are late: they count at the time that they tell of."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.config import estimator_config
from aerial_gnss_ros.core.inputs import Inputs, Samples
from aerial_gnss_ros.core.rejection import Input
from aerial_gnss_ros.core.values import Fix, Orientation, Scalar


@pytest.mark.parametrize("latency_s", [0.0, 0.25, -0.25])
def test_a_gimbal_that_is_stamped_late(latency_s) -> None:
    """It turns by 0.1 rad a second; stamped 0.25 s late, it stands 0.025 rad farther."""
    config = estimator_config({"gimbal": {"latency_s": latency_s}})
    inputs = Inputs(config)
    for k in range(41):
        stamp = 10**18 + k * 100_000_000
        half = 0.05 * 0.1 * k
        inputs.add(Input.GIMBAL, Orientation(stamp, np.array([0, 0, np.sin(half), np.cos(half)])))
        inputs.add(Input.FIX, Fix(stamp, 0.2, -1.0, 0.0))
        inputs.add(Input.HEIGHT, Scalar(stamp, 20.0))
    found = inputs.at(10**18 + 2_000_000_000)
    assert isinstance(found, Samples)
    assert found.gimbal is not None
    yaw = 2.0 * np.arctan2(found.gimbal.quaternion[2], found.gimbal.quaternion[3])
    assert yaw == pytest.approx(0.2 + 0.1 * latency_s, abs=1e-6)
