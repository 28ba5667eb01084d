# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A low search pattern: robots of one class cross the view in seconds, again and again."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from aerial_gnss_ros.core.values.estimates import State

pytestmark = pytest.mark.flights

LEG_M, SPEED_MPS, HEIGHT_M, FIRST_PASSES_S, END_S = 34.0, 4.0, 13.0, 20.0, 90.0
ROBOTS = {"a": (0.0, 0.0), "b": (1.8, 1.0), "c": (4.2, -1.2), "d": (0.6, -2.6)}


def _to_and_fro(t, length, speed):
    """Return the place along a leg that is flown to and fro, m from its middle."""
    return abs((speed * t) % (2.0 * length) - length) - 0.5 * length


def _drone(t):
    return _to_and_fro(t, LEG_M, SPEED_MPS), _to_and_fro(t, 6.0, 0.4) - 1.0, HEIGHT_M


@pytest.mark.parametrize(("offset", "seed"), [((1.1, -0.7), 1), ((-0.5, 1.3), 2), ((0.9, 0.8), 3)])
def test_robots_in_view_have_positions_under_one_label_each(sea, offset, seed):
    """The receiver is off by a metre; heading, box centres and a twentieth of the boxes, too."""
    robots = {name: lambda _t, place=place: place for name, place in ROBOTS.items()}
    world = sea.World(
        drone=_drone, rpy_deg=lambda _t: (0.0, 75.0, 90.0), robots=robots, gnss_bias=offset,
        rpy_bias_deg=(0.2, -0.3, 1.0), pixel_sigma=2.0, missed=0.05, seed=seed,
    )  # fmt: skip
    shown: Counter[int] = Counter()
    frame = world.frame

    def counted(t, class_id="aqua"):
        found = frame(t, class_id)
        shown[found.stamp_ns] = len(found.centers)
        return found

    world.frame = counted
    results = sea.play(sea.estimator(), world, END_S, images=10)
    begin = sea.stamp(FIRST_PASSES_S)
    boxes = sum(count for stamp, count in shown.items() if stamp >= begin)
    given = sum(
        one.state is State.CONFIRMED
        for result in results
        if result.stamp_ns >= begin
        for one in result.estimates
    )
    assert 0.88 * boxes <= given <= boxes
    owners: dict[str, Counter[str]] = {}
    for result in results:
        for one in result.estimates:
            if one.state is State.CONFIRMED:
                nearest = min(
                    ROBOTS, key=lambda name: np.hypot(*(one.position - offset - ROBOTS[name]))
                )
                owners.setdefault(one.robot_id, Counter())[nearest] += 1
    assert {one.robot_id for one in results[-1].estimates} == {f"aqua_{i}" for i in range(1, 5)}
    assert len(owners) <= 5  # one was new for a moment
    bearers = {label: robot.most_common(1)[0] for label, robot in owners.items()}
    assert all(count >= 0.95 * owners[label].total() for label, (_, count) in bearers.items())
    last = {one.robot_id for one in results[-1].estimates}
    assert {bearers[label][0] for label in last} == {*ROBOTS}
