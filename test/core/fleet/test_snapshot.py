# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots of one image for any errors of the drone."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.snapshot import Snapshot
from aerial_gnss_ros.core.models.platform_model import COUNT, LATENCY


@pytest.fixture
def snapshot(two_rtk):
    fleet, _ = two_rtk.together()
    drone = fleet._drones[1]
    return fleet, Snapshot(drone, [label for label in drone.last.labels[::-1] if label])


def test_robots_lie_where_the_filter_has_them(snapshot):
    fleet, one = snapshot
    errors, _ = fleet.table.state.platform(1)
    of = {robot.labels[1]: slot for slot, robot in enumerate(fleet.table.robots)}
    places = fleet.table.state.joint.robots[[of[label] for label in one.labels], :2]
    assert np.linalg.norm(one.placed(errors).places - places, axis=1).max() < 0.3
    assert one.class_ids == ["aqua"] * 3


@pytest.mark.parametrize("at", [0.0, 0.4])
def test_derivatives_are_those_of_the_places(snapshot, at):
    _, one = snapshot
    start = np.array([0.3, -0.2, 0.1, 0.01, -0.01, at, 0.0, 0.0, 0.0])
    placed = one.placed(start)
    for k in range(LATENCY) if not at else (0, 1, 2, 5, 6, 7):
        step = np.zeros(COUNT)
        step[k] = 1e-4
        found = (one.placed(start + step).places - placed.places) / 1e-4
        np.testing.assert_allclose(placed.by_errors[:, :, k], found, rtol=0.02, atol=0.4)
    sigma = np.sqrt(placed.white[:, 0, 0])
    assert (sigma > 0.01).all()
    assert (sigma < 0.5).all()
