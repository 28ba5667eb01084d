# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A box that stays in one pixel (a leg of the drone, dirt on the lens) moves no robot."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.values.estimates import State

pytestmark = pytest.mark.flights

ROBOTS = {"a": (2.0, 18.0), "b": (-3.0, 22.0), "c": (6.0, 24.0)}
END_S, LAST_S = 25.0, 10.0


def angle(t):
    return 2.0 * math.pi / 60.0 * t


def flown(sea, fixed=None, from_s=0.0):
    """Errors m, and in sigmas, of robots in the last seconds of a circle around them."""
    world = sea.World(
        drone=lambda t: (22.0 * math.cos(angle(t)), 21.0 + 22.0 * math.sin(angle(t)), 30.0),
        rpy_deg=lambda t: (0.0, 53.0, math.degrees(angle(t)) + 180.0),
        robots={name: lambda _t, place=place: place for name, place in ROBOTS.items()},
        rpy_bias_deg=(0.2, -0.2, 0.8), pixel_sigma=2.0,
    )  # fmt: skip
    plain = world.frame

    def frame(t):
        found = plain(t)
        if fixed is None or t < from_s:
            return found
        both = sea.boxes(t, [*found.centers.tolist(), fixed])
        return replace(both, scores=np.append(found.scores, 0.6))

    world.frame = frame
    engine = sea.estimator({"noise.gnss_offset_m": 0.02, "camera.find_latency": False})
    results = sea.play(engine, world, END_S, images=10)
    errors, sigmas = [], []
    for result in results:
        if result.stamp_ns < sea.stamp(END_S - LAST_S):
            continue
        for one in result.estimates:
            if one.state is State.CONFIRMED:
                apart = np.array(list(ROBOTS.values())) - one.position
                error = apart[np.argmin(np.linalg.norm(apart, axis=1))]
                errors.append(float(np.linalg.norm(error)))
                sigmas.append(math.sqrt(error @ np.linalg.solve(one.covariance[:2, :2], error)))
    labels = {one.robot_id for result in results for one in result.estimates}
    return np.array(errors), np.array(sigmas), labels


@pytest.mark.parametrize(("fixed", "from_s"), [((60.0, 40.0), 0.0), ((60.0, 440.0), 10.0)])
def test_robots_stay_where_they_are(sea, fixed, from_s):
    errors, sigmas, labels = flown(sea, fixed, from_s)
    alone, _, _ = flown(sea)
    assert labels == {"aqua_1", "aqua_2", "aqua_3"}
    assert len(errors) == len(alone)
    assert np.sqrt(np.mean(errors**2)) < 1.2 * np.sqrt(np.mean(alone**2)) + 0.02
    assert sigmas.max() < 3.7  # chi-square 13.8
