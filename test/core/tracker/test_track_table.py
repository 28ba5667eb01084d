# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What association and filter decide is carried out on the records of the tracks."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.association.decision import Association
from aerial_gnss_ros.core.association.track import TUNING as TRACK
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
    return Measurements(
        every, squares[:, 0], squares[:, 0], squares, names, np.array(edges), squares[:, 0]
    )


def table(*states, refused=(), active=False):
    """Return a table of tracks seen one second ago, over a filter that notes what it is asked."""
    asked = []
    velocities = np.zeros((len(states), 4))
    velocities[:, 2] = 0.5
    joint = SimpleNamespace(
        correct=lambda *_: np.array(refused, np.intp),
        moments=lambda: (velocities, np.tile(np.eye(4), (len(states), 1, 1))),
        monitor=SimpleNamespace(update_matches=lambda *both: asked.append(("monitor", both))),
        speeds=lambda rows: 0.2 * rows.size,
        inflate_velocities=lambda rows, *by: asked.append(("inflate", rows.tolist(), *by)),
        update_reacquired=lambda rows, *_: asked.append(("reacquired", rows.tolist())),
        ambiguity=SimpleNamespace(active=active),
        log=SimpleNamespace(add=lambda sentence: asked.append(("log", sentence))),
    )
    found = TrackTable(joint)
    for row, state in enumerate(states):
        label = "" if state is State.TENTATIVE else f"aqua_{row}"
        found.tracks.append(Track("aqua", 0, SECOND, state, label, (0, SECOND)))
    return found, asked


@pytest.mark.parametrize("active", [False, True])
def test_what_association_decides_is_carried_out(active):
    tracks, asked = table(State.CONFIRMED, State.TENTATIVE, active=active)
    tracks.tracks[1].clutter_probability = 0.5
    decided = Association(
        np.array([0]),
        np.array([0]),
        [0],
        [0],
        {1: 0.1},
        {1},
        3,
        4,
        "Boxes lie elsewhere.",
    )
    three = np.zeros((1, 2)), np.eye(2)[None]
    able = SimpleNamespace(pairs=SimpleNamespace(
        rows=np.array([0]), offsets=three[0], spread=three[1]
    ))  # fmt: skip
    tracks.apply(decided, able)
    robot, new = tracks.tracks
    assert (robot.near_misses, new.near_misses) == (0, 1)
    assert new.clutter_probability == pytest.approx(0.05)
    assert asked.pop(0) == ("log", "Boxes lie elsewhere.")
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


def test_a_measured_robot_is_used_to_its_speed_by_the_time_since_it_was_seen():
    tracks, _ = table(State.CONFIRMED, State.TENTATIVE)
    both = np.arange(2)
    for stamp_s, count in ((2, 0.2), (3, 0.4), (50, 1.4)):  # of five seconds, at most one
        tracks.update(measurements([False] * 2), both, both, stamp_s * SECOND, SECOND)
        robot, new = tracks.tracks
        assert robot.speed_history_count == pytest.approx(count)
        assert robot.speed_history == pytest.approx(count * 0.5 * 0.5**2)
        assert new.speed_history_count == new.speed_history == 0.0


@pytest.mark.parametrize(("late_ns", "expected"), [(0, 1), (1, 0)])
def test_robots_that_were_in_view_are_expected_to_be_shown(late_ns, expected):
    tracks, _ = table(State.CONFIRMED, State.TENTATIVE, State.CONFIRMED)
    tracks.tracks[2].leaving_view = True
    stamp_ns = SECOND + TRACK.recent_ns + late_ns
    assert tracks.misfit(measurements([]), stamp_ns, 8.0) == 4.0 * expected


@pytest.mark.parametrize("speed", [0.5, np.array([0.5, 1.0])])
def test_separations_allow_each_robot_its_own_manoeuvre(speed):
    tracks, _ = table(State.CONFIRMED, State.CONFIRMED, State.TENTATIVE)
    tracks.filter.speeds = lambda _rows: speed
    tracks.filter.separations = lambda old, new: (
        np.zeros((len(old), len(new), 2)), np.tile(np.eye(2), (len(old), len(new), 1, 1))
    )  # fmt: skip
    _, spread = tracks.separations([0, 1], [2])
    own = np.broadcast_to(np.square(MOTION_MODEL.swerve_s * np.asarray(speed)), 2)
    np.testing.assert_allclose(spread[:, 0], (1.0 + own)[:, None, None] * np.eye(2))
