# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ANAFI's position: its variances come in the order latitude, longitude."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.adapters import anafi
from aerial_gnss_ros.bags.typestore import make
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.telemetry.validity import validate

CONFIG = estimator_config({"fix.type": "anafi_fix"}).fix
FIX = "sensor_msgs/msg/NavSatFix"


def test_east_comes_first():
    diagonal = np.diag([4.0, 9.0, 25.0]).ravel()  # latitude, longitude, altitude
    fix = anafi.fix(
        make(FIX, {"position_covariance": diagonal, "position_covariance_type": 2}), 5, CONFIG
    )
    np.testing.assert_array_equal(np.diagonal(fix.covariance), [9.0, 4.0, 25.0])
    assert anafi.fix(make(FIX, {}), 5, CONFIG).covariance is None


def test_a_position_that_the_drone_does_not_know_is_of_no_use():
    unknown = make(FIX, {"latitude": float("nan"), "longitude": float("nan")})
    assert "not on Earth" in validate(anafi.fix(unknown, 5, CONFIG))[0]
