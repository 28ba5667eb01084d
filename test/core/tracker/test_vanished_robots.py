# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Who vanished in view as soon as foam does is not published, and keeps its label."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.flights

UNSURE = {"detections.min_score": 0.6}
"""Boxes score 0.9: of two transients, 2 exp(-0.3 / 0.11) = 0.13 score so. Of 120 dives there is one
for each transient that dissolves, so that 2.8 s decide: 120 * 0.13 exp(-2.8) = 1."""
WINDOW_S = 2.0


def flown(sea, seen_s, unseen_s=10.0, values=UNSURE, **changes):
    """Return when a robot is published whose boxes come until `seen_s` and after `unseen_s`, s."""
    robots = {"here": lambda _t: (3.0, 22.0), "gone": lambda _t: (-3.0, 20.0)}
    world = sea.World(robots=robots, **changes)
    world.hidden = lambda name, t: name == "gone" and seen_s < t < unseen_s
    results = sea.play(sea.estimator(values), world, 12.0)
    begin = sea.stamp(0.0)
    return {
        name: [
            (r.stamp_ns - begin) * 1e-9
            for r in results
            for one in r.estimates
            if one.robot_id == name
        ]
        for name in {one.robot_id for r in results for one in r.estimates}
    }


def test_what_vanished_soon_is_left_out_until_it_is_seen_again(sea):
    published = flown(sea, 1.5)
    assert sorted(published) == ["aqua_1", "aqua_2"]
    here, gone = sorted(published.values(), key=len, reverse=True)
    assert len(here) == pytest.approx(55, abs=2)  # each image since it was confirmed
    before, after = [t for t in gone if t < 10.0], [t for t in gone if t >= 9.9]
    assert max(before) == pytest.approx(1.4 + WINDOW_S, abs=0.2)
    assert min(after) == pytest.approx(11.1, abs=0.3)  # so long foam of that score may last
    assert after[-1] == pytest.approx(12.0)


@pytest.mark.parametrize(
    ("seen_s", "values"),
    [
        (4.0, UNSURE),
        (1.5, {}),
        (1.5, UNSURE | {"tracks.coast_s": 12.0}),
        (1.5, UNSURE | {"classes.aqua.coast_s": 12.0}),
    ],
    ids=["it lasted", "it scores high", "robots dive often", "its class dives often"],
)
def test_what_is_a_robot_rather_than_foam_coasts(sea, seen_s, values):
    gone = min(flown(sea, seen_s, values=values).values(), key=len)
    assert sum(seen_s + WINDOW_S + 1.0 < t < 9.5 for t in gone) == pytest.approx(
        5 * (8.5 - seen_s - WINDOW_S), abs=2
    )


def test_what_the_camera_no_longer_shows_coasts(sea):
    """It looks elsewhere as soon as the robot would be missed."""

    def turned(t):
        return (0.0, 60.0, 90.0 if t < 1.7 else 90.0 + min(90.0 * (t - 1.7), 150.0))

    gone = min(flown(sea, 1.5, rpy_deg=turned).values(), key=len)
    assert sum(4.0 < t < 9.5 for t in gone) > 25
