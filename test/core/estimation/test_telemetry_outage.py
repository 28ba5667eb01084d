# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots change places while images have no pose or a wrong one; images show which went where."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.geometry.frames import (
    matrix_from_quaternion,
    matrix_from_rpy,
    quaternion_from_matrix,
)
from aerial_gnss_ros.core.values.estimates import State

pytestmark = pytest.mark.flights

OUT_S, BACK_S, END_S = 12.0, 16.0, 24.0
SPEED_MPS = 0.8


def _swim(start, velocity):
    """Return the path of a robot that stays, and swims from the outage's beginning to its end."""

    def place(t):
        moved = min(max(t - OUT_S, 0.0), BACK_S - OUT_S)
        return start[0] + velocity[0] * moved, start[1] + velocity[1] * moved

    return place


@pytest.mark.parametrize("fault", ["missing", "turned"])
def test_robots_that_change_places_in_an_outage_keep_their_labels(sea, monkeypatch, fault):
    """Positions alone would give each the other one's label."""
    half = 0.5 * SPEED_MPS * (BACK_S - OUT_S)
    robots = {
        "a": _swim((-half, 0.5), (SPEED_MPS, 0.0)),
        "b": _swim((half, -0.5), (-SPEED_MPS, 0.0)),
    }
    world = sea.World(
        drone=lambda _t: (0.0, 0.0, 20.0), rpy_deg=lambda _t: (0.0, 75.0, 90.0), robots=robots,
        pixel_sigma=1.0, seed=1,
    )  # fmt: skip
    engine = sea.estimator()
    add_gimbal = engine.add_gimbal

    def faulty(sample):
        seconds = (sample.stamp_ns - sea.stamp(0.0)) * 1e-9
        if OUT_S <= seconds < BACK_S:
            if fault == "missing":
                return
            wrong = matrix_from_rpy(0.0, 0.0, 0.5) @ matrix_from_quaternion(sample.quaternion)
            sample = replace(sample, quaternion=quaternion_from_matrix(wrong[None])[0])
        add_gimbal(sample)

    monkeypatch.setattr(engine, "add_gimbal", faulty)
    results = sea.play(engine, world, END_S, images=10)

    def nearest(result):
        t = (result.stamp_ns - sea.stamp(0.0)) * 1e-9
        return {
            one.robot_id: min(robots, key=lambda n: np.hypot(*(one.position - robots[n](t))))
            for one in result.estimates
            if one.state is State.CONFIRMED
        }

    before = next(r for r in results if r.stamp_ns >= sea.stamp(OUT_S - 1.0))
    assert sorted(nearest(before).values()) == ["a", "b"]
    assert nearest(results[-1]) == nearest(before)
