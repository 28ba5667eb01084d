# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What comes up inside a coasting robot's gate: that robot, another one, or a new one."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.identity import reidentification
from aerial_gnss_ros.core.identity.reidentification import Reidentification, duplicate_tracks
from aerial_gnss_ros.core.identity.return_position import VelocityLikelihood
from aerial_gnss_ros.core.identity.returns import ReturnCandidates, Returns
from aerial_gnss_ros.core.models.evidence import UNCLEAR
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.values.estimates import State

SECOND = 1_000_000_000
MOTION = MotionModel(0.05, 0.75)


def _unseen(count):
    """Return velocities that nobody has seen."""
    return VelocityLikelihood(np.zeros((count, 2)), np.broadcast_to(1e4 * np.eye(2), (count, 2, 2)))


def _pairs(*places, **more):
    found, waiting, _ = _pairs_and_odds(*places, **more)
    return found, waiting


def _pairs_and_odds(down, up, unseen_s, newcomers=0.1, waited_s=0.2, beside=True):
    """Robots went down at `down`, tracks came up at `up` (East, North, m)."""
    now = 1000 * SECOND
    left, came = now - round(unseen_s * SECOND), now - round(waited_s * SECOND)
    tracks = [
        Track(
            "aqua",
            0,
            left,
            State.COASTING,
            f"aqua_{i}",
            (left,),
            speed_history=0.4,
            speed_history_count=9.0,
        )
        for i in range(len(down))
    ]
    tracks += [
        Track("aqua", came, now, hits=(came, now) if beside else (came + i, now + i))
        for i in range(len(up))
    ]
    offsets = np.array(up, float)[None] - np.array(down, float)[:, None]
    variance = MOTION.step(unseen_s, np.full(1, 1e-3))[2][0, 0] + 0.1
    spread = np.broadcast_to(variance * np.eye(2), (*offsets.shape, 2))
    n = len(down)
    given = ReturnCandidates(
        tracks, list(range(n)), list(range(n, len(tracks))), (offsets, spread),
        _unseen(len(up)), now, 30.0, newcomers,
    )  # fmt: skip
    came = Reidentification(MOTION, 11.6, 180.0).decide(given)
    odds = {
        (one, other - n): p
        for one, law in came.label_probabilities.items()
        for other, p in law.items()
    }
    found = {new - n: old for new, old in came.robots.items()}
    assert came.ended == {*came.label_probabilities} - {*came.robots.values()}
    return found, {row - n for row in came.waiting}, odds


@pytest.mark.parametrize(
    ("down", "up", "unseen_s", "newcomers", "found"),
    [
        ([(0, 0)], [(3, 2)], 60.0, 1.0, {0: 0}),
        ([(0, 0)], [(40, 0)], 20.0, 0.1, {}),  # 2 m/s: not inside the gate
        ([(0, 0)], [(18, 0)], 30.0, 1.0, {}),  # inside, but likelier one that nobody knows yet
        ([(0, 0)], [(18, 0)], 30.0, 0.0, {0: 0}),  # unless all robots have been seen
        ([(0, 0), (30, 0)], [(29, 1)], 20.0, 0.1, {0: 1}),
    ],
)
def test_who_came_up(down, up, unseen_s, newcomers, found):
    """Once it has shown how it swims."""
    assert _pairs(down, up, unseen_s, newcomers, waited_s=1.5) == (found, set())


def test_in_doubt_it_waits_to_show_how_it_swims():
    """Whether it is that robot, or which is which of two that came up midway."""
    midway = [(0, 0), (2, 0)], [(1, 0), (1.1, 0)], 10.0
    assert _pairs(*midway) == ({}, {0, 1})
    assert _pairs(*midway, waited_s=1.5)[1] == set()
    assert _pairs([(0, 0)], [(18, 0)], 30.0, 1.0) == ({}, {0})


@pytest.mark.parametrize(
    ("east", "found"),
    [(1.2, {}), (2.5, {0: 1})],
    ids=["as good as midway: a new name", "much nearer to one"],
)
def test_between_two_robots_it_waits_but_not_for_ever(east, found):
    assert _pairs([(0, 0), (2, 0)], [(east, 0)], 10.0) == ({}, {0})
    assert _pairs([(0, 0), (2, 0)], [(east, 0)], 10.0, waited_s=6.0) == (found, set())


def test_two_that_come_up_together_are_distinguished_by_relative_position():
    """Both seem 1.2 m further east, so that one seems nearer to the place of the other."""
    found, waiting = _pairs([(0, 0), (2, 0)], [(3.2, 0), (1.2, 0)], 10.0, waited_s=1.5)
    assert (found, waiting) == ({0: 1, 1: 0}, set())


@pytest.mark.parametrize(
    ("up", "found", "low", "high"),
    [
        ([(0, 0), (6, 0)], {0: 0, 1: 1}, 0.0, 0.2),
        ([(1, 0), (1.1, 0)], {}, 0.3, 0.5),  # both between the two: nobody knows, new names
    ],
)
def test_how_likely_the_other_way_round_is_reported(up, found, low, high):
    named, _, odds = _pairs_and_odds([(0, 0), (2, 0)], up, 10.0, waited_s=1.5)
    assert named == found
    assert low <= odds[0, 1] <= high + 1e-9
    assert odds[0, 0] == odds[1, 1] == pytest.approx(1.0 - odds[0, 1])


def test_three_that_come_up_midway_may_be_each_others_in_a_ring():
    """Nobody knows any of them: each name is on each track alike, which exchanges of two miss."""
    down = [(0, 0), (2, 0), (1, 1.732)]
    _, _, odds = _pairs_and_odds(down, [(1, 0.577)] * 3, 10.0, waited_s=1.5)
    assert odds == pytest.approx({(i, j): 1 / 3 for i in range(3) for j in range(3)}, abs=0.02)


def test_those_that_come_up_one_after_the_other_wait_for_the_last():
    """The first of three came 6 s ago and would have given up, but the second came just now."""
    now = 1000 * SECOND
    down, up = [(0, 0), (2, 0), (1, 2)], [(0.9, 0.5), (1.1, 0.5)]
    tracks = [
        Track("aqua", 0, now - 10 * SECOND, State.COASTING, f"aqua_{i}", (1,)) for i in range(3)
    ]
    tracks += [Track("aqua", now - round(ago * SECOND), now, hits=(now,)) for ago in (6.0, 0.2)]
    offsets = np.array(up, float)[None] - np.array(down, float)[:, None]
    spread = np.broadcast_to(9.0 * np.eye(2), (3, 2, 2, 2))
    for ready, waits in (([3, 4], {3, 4}), ([3], set())):
        between = offsets[:, : len(ready)], spread[:, : len(ready)]
        unseen = _unseen(len(ready))
        given = ReturnCandidates(tracks, [0, 1, 2], ready, between, unseen, now, 30.0, 0.1)
        came = Reidentification(MOTION, 11.6, 180.0).decide(given)
        assert came.waiting == waits


def test_two_tracks_that_no_image_shows_together_are_not_two_robots():
    found, waiting = _pairs([(0, 0), (2, 0)], [(0.9, 0), (1.1, 0)], 10.0, beside=False)
    assert (found, waiting) == ({}, {0, 1})


@pytest.mark.parametrize(
    ("apart", "hits", "found"),
    [(0.5, (1, 3), {1: 0}), (0.5, (2, 3), {}), (9.0, (1, 3), {})],
    ids=["one robot", "seen beside", "far off"],
)
def test_a_second_track_on_one_robot_is_folded_into_the_first(apart, hits, found):
    tracks = [Track("aqua", one[0], one[-1], hits=one) for one in ((0, 2), tuple(hits))]
    offsets = np.array([[[0.0, 0.0], [apart, 0.0]], [[-apart, 0.0], [0.0, 0.0]]])
    spread = np.broadcast_to(0.1 * np.eye(2), (2, 2, 2, 2))
    assert duplicate_tracks(tracks, [0, 1], (offsets, spread), 11.6) == found


def test_absences_of_robots_that_left_the_view_tell_nothing():
    """60 s, but only where the robot went down and came up well inside the picture."""
    old, new = (Track("aqua", 0, stamp * SECOND, State.COASTING) for stamp in (10, 70))
    new.first_seen_ns = 70 * SECOND
    assert reidentification._absence(old, new) == pytest.approx(60.0)
    for one, edge in ((old, "leaving_view"), (new, "entered_view")):
        setattr(one, edge, True)
        assert np.isnan(reidentification._absence(old, new))
        setattr(one, edge, False)


def test_other_robots_that_a_track_may_be_are_remembered_where_they_are_likely_enough():
    """Robots 4 and 7 were out of view; the track 9 is 4 by 0.6, 7 by 0.3, new by 0.1."""
    unsure = UNCLEAR
    done, search = Returns(robots={9: 4}), Reidentification(MOTION, 11.6, 180.0)
    search._with_alternatives(
        done, [4, 7, 8], [5, 9], np.array([[0.0, 0.6], [0.0, 0.3], [1.0, 0.9 * unsure]])
    )
    assert done.other == {(9, 4): 0.6, (9, 7): 0.3}
    assert done.unknown == {9: pytest.approx(0.1 - 0.9 * unsure)}


def _crossing_view(label, seen_s, now, **more):
    """Return a track that the camera left or found at the edge of the image."""
    came, left = (now - round(ago * SECOND) for ago in seen_s)
    track = Track("aqua", came, left, robot_id=label, hits=(came, left), **more)
    track.state = State.COASTING if label else State.TENTATIVE
    track.entered_view = track.leaving_view = True
    return track


def _decide(search, tracks, away, ready, places, now):
    offsets = places[ready][None] - places[away][:, None]
    spread = np.broadcast_to(1.5 * np.eye(2), (*offsets.shape, 2))
    velocities = _unseen(len(ready))
    return search.decide(
        ReturnCandidates(tracks, away, ready, (offsets, spread), velocities, now, 13.0, 0.1)
    )


def test_a_new_label_is_given_up_as_soon_as_it_is_clear_whose_it_was():
    """Midway between two robots that the camera left; then the other one is found, too."""
    now, search = 1000 * SECOND, Reidentification(MOTION, 11.6, 180.0)
    places = np.array([(0.0, 0.0), (2.4, 0.0), (1.1, 0.0), (2.5, 0.1)])
    lost = [_crossing_view(f"aqua_{i}", (30.0, 6.0), now) for i in range(2)]
    tracks = [*lost, _crossing_view("", (1.2, 0.0), now)]
    first = _decide(search, tracks, [0, 1], [2], places[:3], now)
    assert (first.robots, first.waiting) == ({}, set())
    assert set(first.may_be[2]) == {"aqua_0", "aqua_1"}
    tracks[2].robot_id, tracks[2].may_be = "aqua_2", first.may_be[2]
    tracks.append(_crossing_view("", (1.1, 0.0), now))
    second = _decide(search, tracks, [0, 1, 2], [3], places, now)
    assert second.robots == {2: 0, 3: 1}


def test_a_track_where_one_with_a_new_label_was_is_that_one():
    """Two old labels and a new one are candidates, the newest of the three by far the likeliest."""
    now, search = 1000 * SECOND, Reidentification(MOTION, 11.6, 180.0)
    places = np.array([(0.0, 0.0), (2.4, 0.0), (1.0, 0.0)])
    lost = [_crossing_view(f"aqua_{i}", (30.0, 6.0), now) for i in range(2)]
    tracks = [*lost, _crossing_view("", (1.2, 0.0), now)]
    first = _decide(search, tracks, [0, 1], [2], places, now)
    tracks[2].robot_id, tracks[2].may_be = "aqua_2", first.may_be[2]
    later, places = now + 3 * SECOND, np.vstack([places, (1.0, 0.1)])
    tracks.append(_crossing_view("", (1.1, 0.0), later))
    second = _decide(search, tracks, [0, 1, 2], [3], places, later)
    assert second.robots.get(3) == 2
