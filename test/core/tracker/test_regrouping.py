# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that are all elsewhere keep their labels, and their old places for a while."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.tracker.regrouping import Regrouping
from aerial_gnss_ros.core.tracker.track_table import TrackTable
from aerial_gnss_ros.core.values.estimates import State

GATE = 9.0


def scene(old, new, previous=()):
    """Return a regrouping and its table of robots out of sight and new tracks at places, m."""
    places = np.array([*old, *new], dtype=float)
    merged = []

    def separations(one, other):
        return places[other][None] - places[one][:, None], np.tile(
            np.eye(2), (len(one), len(other), 1, 1)
        )

    mean = np.column_stack([places, np.zeros_like(places)])
    joint = SimpleNamespace(
        separations=separations, speeds=lambda _: 0.0, moments=lambda: (mean, None),
        inflate_velocities=lambda *_: None, merge=lambda *which: merged.append(which[:2]),
        note_return=lambda: merged.append("returned"),
        formation=lambda *asked: merged.append(asked),
    )  # fmt: skip
    table = TrackTable(joint)
    for i in range(len(old)):
        one = Track("aqua", 0, 0, State.COASTING, f"aqua_{i}")
        if i in previous:
            one.robot_id, one.previous_label = "", one.robot_id
        table.tracks.append(one)
    table.tracks += [Track("aqua", 0, 0) for _ in new]
    return Regrouping(table, GATE), table, merged


@pytest.mark.parametrize(
    ("new", "back"),
    [
        ([(0.0, 2.9), (9.0, 2.9)], True),
        ([(0.0, 2.9), (9.0, 3.1)], True),
        ([(0.0, 3.1), (9.0, 3.1)], False),
        ([], False),
    ],
    ids=["both", "one of two", "none", "nothing new"],
)
def test_robots_are_back_when_half_of_them_are(new, back):
    found, table, _ = scene([(0.0, 0.0), (9.0, 0.0)], new)
    ready = list(range(2, len(table.tracks)))
    assert found.are_back(ready, boxes=2) is back
    assert not found.are_back(ready, boxes=2, previous=True)


def test_robots_that_moved_leave_their_old_places_behind():
    found, table, merged = scene([(0.0, 0.0), (5.0, 0.0)], [(0.0, 20.0), (5.0, 20.0)])
    assert found.relabel({2: 0, 3: 1}, moved=True) == set()
    assert [(one.robot_id, one.previous_label) for one in table.tracks] == [
        ("", "aqua_0"), ("", "aqua_1"), ("aqua_0", ""), ("aqua_1", ""),
    ]  # fmt: skip
    assert merged == []
    assert found.displacement({2: 0, 3: 1}) == 400.0
    found.restore_labels()
    assert [one.robot_id for one in table.tracks] == ["aqua_0", "aqua_1", "", ""]
    assert [one.rejected for one in table.tracks] == [False, False, True, True]
    assert merged == ["returned"]


def test_robots_that_did_not_move_go_on_in_the_new_tracks():
    found, table, merged = scene([(0.0, 0.0), (5.0, 0.0)], [(0.1, 0.0), (5.1, 0.0)])
    assert found.relabel({2: 0, 3: 1}, moved=False) == {0, 1}
    assert merged == [(0, 2), (1, 3)]
    assert [one.state for one in table.tracks[2:]] == [State.CONFIRMED] * 2


@pytest.mark.parametrize(
    ("new", "home"),
    [
        ([(0.1, 0.0), (5.1, 0.0)], True),
        ([(0.1, 0.0), (8.1, 0.0)], False),
        ([(2.6, 0.0), (2.4, 0.0)], False),  # each is nearer to the place of the other one
    ],
)
def test_at_home_are_all_robots_or_none(new, home):
    found, table, _ = scene([(0.0, 0.0), (5.0, 0.0), (50.0, 0.0), (55.0, 0.0)], new, (0, 1))
    for row, name in ((2, "aqua_0"), (3, "aqua_1")):
        table.tracks[row].robot_id = name
    assert found.at_home({4: 2, 5: 3}) is home


def test_only_robots_and_tracks_of_one_class_can_be_the_same():
    old, new = [(0.0, 0.0), (5.0, 0.0), (0.0, 5.0)], [(1.0, 0.0), (6.0, 0.0), (1.0, 5.0)]
    found, table, asked = scene(old, new)
    for row, name in ((1, "buoy"), (4, "buoy")):
        table.tracks[row].class_id = name
    assert found.formation_match([3, 4, 5], {"aqua_0", "aqua_1", "aqua_2"}) is None
    ((rows, ready, _, possible),) = asked
    assert (rows, ready) == ([0, 1, 2], [3, 4, 5])
    assert possible.tolist() == [
        [True, False, True], [False, True, False], [True, False, True],
    ]  # fmt: skip
