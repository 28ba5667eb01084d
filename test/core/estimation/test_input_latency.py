# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fixes and heights whose stamps are late: they count at the time that they tell of."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.scene import SceneTelemetry
from aerial_gnss_ros.core.values.rejection import Input
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar


@pytest.mark.parametrize("latency_s", [0.0, 0.25, -0.25])
def test_a_fix_and_a_height_that_are_stamped_late(latency_s) -> None:
    """They rise by 1e-6 rad and 1 m a second; stamped 0.25 s late, they stand that much farther."""
    late = {"latency_s": latency_s}
    inputs = TelemetryBuffers(estimator_config({"fix": late, "height": late}))
    level = np.array([0.0, 0.0, 0.0, 1.0])
    for k in range(41):
        stamp = 10**18 + k * 100_000_000
        inputs.add(Input.GIMBAL, Orientation(stamp, level))
        inputs.add(Input.FIX, Fix(stamp, 0.2 + 1e-7 * k, -1.0, 0.0))
        inputs.add(Input.HEIGHT, Scalar(stamp, 20.0 + 0.1 * k))
    found = inputs.at(10**18 + 2_000_000_000)
    assert isinstance(found, SceneTelemetry)
    assert found.fix.latitude - 0.2 == pytest.approx(1e-6 * (2.0 + latency_s), abs=1e-10)
    assert found.height == pytest.approx(22.0 + latency_s)
