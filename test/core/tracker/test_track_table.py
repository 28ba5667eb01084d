# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What association and filter decide is carried out on the records of the tracks."""

from __future__ import annotations

from collections import deque
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.association.decision import Association
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.tracker.track_table import TrackTable
from aerial_gnss_ros.core.values.estimates import State

SECOND = 1_000_000_000


def measurements(edges):
    """Return measurements of which nothing but the edge is asked."""
    n = len(edges)
    squares, names = np.zeros((n, 2, 2)), np.full(n, "aqua")
    every = np.arange(n)
    return Measurements(every, squares[:, 0], squares[:, 0], squares, names, np.array(edges))


def table(*states, refused=(), active=False):
    """Return a table of tracks seen one second ago, over a filter that notes what it is asked."""
    asked = []
    velocities = np.zeros((len(states), 4))
    velocities[:, 2] = 0.5
    joint = SimpleNamespace(
        correct=lambda *_: np.array(refused, np.intp),
        moments=lambda: (velocities, np.tile(np.eye(4), (len(states), 1, 1))),
        monitor=SimpleNamespace(update_matches=lambda *both: asked.append(("monitor", both))),
        inflate_velocities=lambda rows, speed, s: asked.append(("inflate", rows, speed, s)),
        update_reacquired=lambda rows, *_: asked.append(("reacquired", rows.tolist())),
        ambiguity=SimpleNamespace(active=active),
    )
    found = TrackTable(joint)
    for row, state in enumerate(states):
        label = "" if state is State.TENTATIVE else f"aqua_{row}"
        found.tracks.append(Track("aqua", 0, SECOND, state, label, deque([0, SECOND])))
    return found, asked


@pytest.mark.parametrize("active", [False, True])
def test_what_association_decides_is_carried_out(active):
    tracks, asked = table(State.CONFIRMED, State.TENTATIVE, active=active)
    tracks.tracks[1].clutter_probability = 0.5
    decided = Association(
        np.array([0]), np.array([0]), [0], {0: 2.5}, [([0], 0.2)], {1: 0.1}, {1}, 3, 4
    )
    three = np.zeros((1, 2)), np.eye(2)[None]
    able = SimpleNamespace(pairs=SimpleNamespace(
        rows=np.array([0]), offsets=three[0], spread=three[1]
    ))  # fmt: skip
    tracks.apply(decided, able)
    robot, new = tracks.tracks
    assert (robot.innovation_ratio, robot.near_misses, new.near_misses) == (2.5, 0, 1)
    assert new.clutter_probability == pytest.approx(0.05)
    assert asked[:2] == [("monitor", (3, 4)), ("inflate", [0], 0.2, MOTION_MODEL.swerve_s)]
    assert asked[2:] == ([("reacquired", [0])] if active else [])


def test_a_measured_track_is_seen_and_a_refused_one_is_not():
    tracks, _ = table(State.COASTING, State.COASTING, State.TENTATIVE, refused=[1])
    every = np.arange(3)
    seen = measurements([True, False, False])
    refused, labelled = tracks.update(seen, every, every, 2 * SECOND, SECOND)
    robot, fast, new = tracks.tracks
    assert (refused.tolist(), labelled) == ([1], 1)
    assert (robot.state, fast.state, new.state) == (
        State.CONFIRMED, State.COASTING, State.TENTATIVE,
    )  # fmt: skip
    assert (robot.leaving_view, new.leaving_view) == (True, False)
    assert [list(one.hits) for one in tracks.tracks] == [
        [SECOND, 2 * SECOND], [0, SECOND], [SECOND, 2 * SECOND],
    ]  # fmt: skip
    assert fast.rejected
    assert not robot.rejected
    assert robot.speed_history == pytest.approx(0.2 * 0.5 * 0.25)  # one second of five
    assert new.speed_history == 0.0
    assert tracks.update(seen, every, every, 3 * SECOND, SECOND)[1] == 0  # refused before


def test_what_is_unverified_and_out_of_view_is_given_up():
    tracks, _ = table(State.COASTING, State.CONFIRMED, State.COASTING)
    for track in tracks.tracks[:2]:
        track.unverified = True
    tracks.give_up_unverified()
    assert [(one.robot_id, one.rejected) for one in tracks.tracks] == [
        ("", True), ("aqua_1", False), ("aqua_2", False),
    ]  # fmt: skip
    assert not any(one.unverified for one in tracks.tracks)
