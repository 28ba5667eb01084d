# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that stay are found out with default parameters; those that do not are not."""

from __future__ import annotations

import math

import numpy as np
import pytest

RTK = {"noise.gnss_offset_m": 0.02}
ORBIT = {
    "drone": lambda t: (28.0 * math.cos(0.15 * t), 20.0 + 28.0 * math.sin(0.15 * t), 30.0),
    "rpy_deg": lambda t: (0.0, 47.0, math.degrees(0.15 * t) + 180.0),
    "rpy_bias_deg": (0.2, 0.3, 1.5),
    "pixel_sigma": 2.0,
}
PLACES = {"a": (2.0, 21.0), "b": (-3.0, 18.0), "c": (1.0, 15.0)}


def robots(drift=(0.0, 0.0), leaves=math.inf):
    """Return robots: all go with a current, one swims off at a time."""

    def place(name):
        def at(t):
            east, north = PLACES[name]
            off = 0.3 * max(t - leaves, 0.0) if name == "a" else 0.0
            return east + drift[0] * t + off, north + drift[1] * t

        return at

    return {name: place(name) for name in PLACES}


def flown(sea, stated=None, seconds=30.0, **motion):
    """Return the last result, its errors (n,), their sizes by its covariances, and its sigma."""
    world = sea.World(robots=robots(**motion), **ORBIT)
    engine = sea.estimator(RTK | {"tracks.find_moored": True} | (stated or {}))
    last = sea.play(engine, world, seconds)[-1]
    t = (last.stamp_ns - sea.stamp(0.0)) * 1e-9
    errors, sizes = [], []
    for one in last.estimates:
        off = min((one.position - place(t) for place in world.robots.values()),
                  key=lambda d: float(d @ d))  # fmt: skip
        errors.append(float(np.linalg.norm(off)))
        sizes.append(float(off @ np.linalg.solve(one.covariance[:2, :2], off)))
    assert len(errors) == len(PLACES)
    sigma = max(math.sqrt(np.trace(one.covariance[:2, :2])) for one in last.estimates)
    return last, np.array(errors), np.array(sizes), sigma


def test_robots_that_stay_are_known_as_if_it_were_told(sea):
    last, errors, sizes, sigma = flown(sea)
    told = {"noise.robot_acceleration": 0.0, "tracks.max_speed": 0.01}
    _, _, _, best = flown(sea, told)
    assert last.current is None
    assert sigma < 1.5 * best
    assert errors.max() < 4.0 * best
    assert sizes.max() < 13.8


def test_one_current_for_all_is_no_platform_error_and_is_told(sea):
    last, errors, sizes, _ = flown(sea, drift=(0.15, -0.1))
    off = last.current.velocity - (0.15, -0.1)
    assert float(off @ np.linalg.solve(last.current.covariance, off)) < 13.8
    assert last.current.covariance.trace() < 0.1**2
    assert sizes.max() < 13.8
    assert errors.max() < 0.4


def test_a_robot_that_leaves_is_followed(sea):
    _, errors, sizes, sigma = flown(sea, leaves=20.0)
    assert sizes.max() < 13.8
    assert sigma < 0.4
    assert errors.max() < 0.5


@pytest.mark.parametrize("seconds", [20.8, 21.6, 22.4])
def test_a_robot_that_has_just_left_is_not_far_off(sea, seconds):
    """It swims 0.3 m/s: for a second its boxes may be noise."""
    _, errors, _, _ = flown(sea, seconds=seconds, leaves=20.0)
    assert errors.max() < 0.45
