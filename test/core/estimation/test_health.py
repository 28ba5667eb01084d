# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A robot in a few words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from aerial_gnss_ros.core.estimation.health import summary
from aerial_gnss_ros.core.values.estimates import State


def test_a_robot_is_reported_with_its_own_numbers(result_at):
    (robot,) = result_at(7, ["aqua_3"], state=State.COASTING).estimates
    reported = summary(replace(robot, covariance=np.diag([4.0, 9.0, 1.0, 1.0])))
    assert (reported.robot_id, reported.class_id, reported.state) == (
        "aqua_3",
        "aqua",
        State.COASTING,
    )
    assert (reported.last_seen_ns, reported.sigma_m) == (6, 3.0)
