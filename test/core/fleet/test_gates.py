# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes that fit their robots, that do not, and those of robots that turned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.gates import fitting, usable


@pytest.fixture
def watched(two_rtk):
    """A fleet that has flown, the last sighting of drone b and what is needed to gate it."""
    fleet, updates = two_rtk.together()
    _, seen, _ = updates[-1]
    drone = fleet._drones[1]
    slots = {
        k: next(i for i, robot in enumerate(fleet.table.robots) if robot.labels.get(1) == label)
        for k, label in enumerate(seen.labels)
    }
    fleet.table.state.look(1, drone.view)

    def gate(moved_px, speed=0.0):
        pixels = seen.pixels.copy()
        pixels[1] += moved_px
        changed = replace(seen, pixels=pixels)
        fits = fitting(fleet.table.state, changed, drone.view, drone.model, slots)
        return usable(fleet.table.state.joint, fleet.table.robots, fits, slots, speed, 11.6)

    return fleet, slots, gate


def test_boxes_near_their_robots_fit_and_one_far_off_does_not(watched):
    _, _, gate = watched
    assert gate((0.0, 0.0)) == [0, 1, 2]
    assert gate((4.0, -3.0)) == [0, 1, 2]
    assert gate((40.0, 0.0)) == [0, 2]


def test_a_box_that_a_turn_explains_fits_and_its_velocity_becomes_unsure(watched):
    fleet, slots, gate = watched
    before = fleet.table.state.joint.blocks()[:, 2, 2]
    assert gate((18.0, 0.0), speed=0.75) == [0, 1, 2]
    more = fleet.table.state.joint.blocks()[:, 2, 2] - before
    assert more[slots[1]] == pytest.approx(0.75**2)
    assert [more[slots[0]], more[slots[2]]] == [0.0, 0.0]
    assert gate((400.0, 0.0), speed=0.75) == [0, 2]


def test_a_good_box_leaves_velocities_alone(watched):
    fleet, _, gate = watched
    before = fleet.table.state.joint.covariance.copy()
    gate((4.0, -3.0), speed=0.75)
    np.testing.assert_array_equal(before, fleet.table.state.joint.covariance)
