# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Two robots that pass closer than their boxes are exact: who is who is decided afterwards."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.identity import encounters
from aerial_gnss_ros.core.identity.encounters import Encounters
from aerial_gnss_ros.core.identity.label_ambiguity import Position
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.values.estimates import State

SECOND = 1_000_000_000
SIGMA = 0.1


class Water:
    """Stands in for the filter: boxes exact to SIGMA, velocities known to 5 cm/s."""

    motion = MotionModel(0.05, 0.5)

    def moments(self):
        """Return what is known of places and velocities."""
        return np.zeros((6, 4)), np.tile(np.diag([1.0, 1.0, 0.05**2, 0.05**2]), (6, 1, 1))

    def box_noise(self, places):
        """Return all of it as the boxes' own."""
        return np.tile(SIGMA**2 * np.eye(2), (len(places), 1, 1))


def follow(meeting, tracks, rows, places, white, stamp_ns):
    """Return which boxes update the tracks, whose labels are exchanged as is decided."""
    boxes, swaps = meeting.follow(tracks, rows, places, white, stamp_ns)
    for one, other in swaps:
        tracks[one].swap_labels(tracks[other])
    return boxes


def _spot(place):
    return Position(place, 0.01 * np.eye(2))


def _meet(seed, closest, swap_from=None, seconds=10.0):
    """Two robots pass at 0.6 m/s; at a time the association takes the boxes the wrong way.

    Otherwise it goes on as it was corrected. Returns the robot that the first one's name is on in
    the end, 0 or 1, and the largest doubt, m².
    """
    rng = np.random.default_rng(seed)
    meeting = Encounters(Water())
    one = Track("aqua", 0, 0, State.CONFIRMED, "aqua_1", velocity=np.array([0.3, 0.0]))
    other = Track("aqua", 0, 0, State.CONFIRMED, "aqua_2", velocity=np.array([-0.3, 0.0]))
    white = np.repeat(SIGMA**2 * np.eye(2)[None], 2, axis=0)
    most, order = 0.0, np.arange(2)
    for i in range(round(10 * seconds)):
        t = 0.1 * i - 0.5 * seconds
        places = np.array([[0.3 * t, 0.0], [-0.3 * t, closest]])
        places += SIGMA * rng.standard_normal((2, 2)) + [100.0, 50.0 * np.sin(t)]
        if swap_from is not None and abs(t - swap_from) < 0.01:
            order = order[::-1]
        order = order[
            follow(meeting, [one, other], np.arange(2), places[order], white, i * SECOND // 10)
        ]
        named = dict(zip((one.robot_id, other.robot_id), order, strict=True))
        doubt = meeting.ambiguity_covariances(
            {name: _spot(places[robot]) for name, robot in named.items()}
        )
        doubt = doubt.get("aqua_1", np.zeros((2, 2)))
        assert np.linalg.eigvalsh(doubt).min() >= -1e-9
        most = max(most, float(np.trace(doubt)))
    return named["aqua_1"], most


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("swap_from", [None, -0.2, 0.0, 0.3])
def test_each_robot_keeps_its_name_whatever_boxes_the_association_gives(seed, swap_from):
    assert _meet(seed, 0.3, swap_from)[0] == 0


@pytest.mark.parametrize(("cost", "boxes"), [(None, [0, 1]), (-10.0, [0, 1]), (10.0, [1, 0])])
def test_the_picture_may_show_that_boxes_were_exchanged(cost, boxes):
    """Two that hardly move lie where they were. `cost` is that of each one's own box."""
    meeting, white = Encounters(Water()), np.repeat(SIGMA**2 * np.eye(2)[None], 2, axis=0)
    tracks = [Track("aqua", 0, 0, State.CONFIRMED, name, velocity=np.zeros(2)) for name in "ab"]
    places = np.array([[0.0, 0.0], [0.2, 0.0]])
    image_cost = None if cost is None else cost * np.eye(2)
    meeting.follow(tracks, np.arange(2), places, white, 0)
    found, _ = meeting.follow(tracks, np.arange(2), places, white, SECOND // 10, image_cost)
    assert found.tolist() == boxes


def test_doubt_is_published_only_while_there_is_some():
    far, near = _meet(1, 2.5)[1], _meet(1, 0.05)[1]
    assert far == 0.0
    assert near > 1e-3  # m²: half of (5 to 10 cm)²


@pytest.mark.parametrize("together", [True, False])
def test_a_meeting_that_nobody_can_decide_stays_in_doubt(together):
    """Two meet, stay in one place for 4 s and part at right angles: even chances, whoever looks."""
    rng = np.random.default_rng(3)
    meeting = Encounters(Water())
    tracks = [Track("aqua", 0, 0, State.CONFIRMED, f"aqua_{i}") for i in (1, 2)]
    white = np.repeat(SIGMA**2 * np.eye(2)[None], 2, axis=0)
    for i in range(140):
        t = 0.1 * i - 5.0
        before, after = min(t, 0.0), max(t - 4.0, 0.0)
        places = np.array([[0.3 * before, 0.3 * after], [-0.3 * before, -0.3 * after]])
        places += SIGMA * rng.standard_normal((2, 2))
        shown = 2 if together or t < 6.0 else 1  # one leaves the picture
        places = places[
            follow(
                meeting, tracks[:shown], np.arange(shown), places[:shown], white, i * SECOND // 10
            )
        ]
    named = {track.robot_id: _spot(np.array([0.0, 6.0 * i])) for i, track in enumerate(tracks)}
    for doubt in meeting.ambiguity_covariances(named).values():
        assert np.diag(doubt) == pytest.approx([0.0, 18.0], abs=9.0)  # half of 6² m²
    assert len(meeting.ambiguity_covariances(named)) == 2


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.integers(2, 6))
def test_names_stay_a_permutation(seed, count):
    """Whatever boxes come, no name is lost or given twice."""
    rng = np.random.default_rng(seed)
    meeting = Encounters(Water())
    tracks = [Track("aqua", 0, 0, State.CONFIRMED, f"aqua_{i}") for i in range(count)]
    white = np.repeat(SIGMA**2 * np.eye(2)[None], count, axis=0)
    for i in range(20):
        shown = rng.permutation(count)[: rng.integers(1, count + 1)]
        places = 0.3 * rng.standard_normal((len(shown), 2))
        stamp_ns = i * SECOND // 10
        follow(meeting, [tracks[j] for j in shown], shown, places, white[: len(shown)], stamp_ns)
        assert sorted(track.robot_id for track in tracks) == [f"aqua_{j}" for j in range(count)]


def test_a_few_boxes_are_paired_as_many_are(monkeypatch):
    places = np.random.default_rng(1).uniform(0.0, 3.0, (8, 2))
    white = np.tile(0.1**2 * np.eye(2), (8, 1, 1))
    few = encounters._close(places, white)
    monkeypatch.setattr(encounters, "MAX_ROWS", 0)
    assert few == encounters._close(places, white)
    assert 3 <= len(few) < 28  # some are close, some are not
    assert encounters._close(places[:0], white[:0]) == []


@pytest.mark.parametrize("origin", [0.0, 100.0])
def test_a_pair_is_followed_until_it_is_far_apart_wherever_that_is(origin):
    meeting = Encounters(Water())
    tracks = [Track("aqua", 0, 0, State.CONFIRMED, f"aqua_{i}") for i in (1, 2)]
    white = np.tile(SIGMA**2 * np.eye(2), (2, 1, 1))
    for i, (half, followed) in enumerate([(2.0, False), (0.3, True), (0.8, True), (0.9, False)]):
        places = origin + np.array([[-half, 0.0], [half, 0.0]])
        follow(meeting, tracks, np.arange(2), places, white, i * SECOND)
        # Closer than 8 sigmas of a box begin it, 12 of a separation (0.14 m) end it.
        assert meeting.ambiguous is followed
