# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which box of an image belongs to which track, where two tracks may be of one robot."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.association.clutter import chance_probability
from aerial_gnss_ros.core.association.matcher import Matcher
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.faults.noise_level import NoiseLevel
from aerial_gnss_ros.core.filter.innovation import PairInnovations
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.values.estimates import State

GATE = math.log(1e-4)
"""Log determinant of a usual gate, 0.1 m one sigma."""


def boxes(count):
    """Return boxes whose places nothing asks for."""
    squares = np.zeros((count, 2, 2))
    names, edge = np.full(count, "aqua"), np.zeros(count, bool)
    return Measurements(
        np.arange(count), squares[:, 0], squares[:, 0], squares, names, edge, squares[:, 0]
    )


def _joint(pairs, speed=0.0):
    """Return what a matcher asks of the joint filter, with these pairs of robots and boxes."""
    return SimpleNamespace(
        compare=lambda *_: pairs,
        motions=SimpleNamespace(largest=speed),
        speeds=lambda _: speed,
        noise=NoiseLevel(),
    )


def _silent():
    """Say nothing about the image."""
    raise AssertionError


def decided(matcher, tracks, seen, now):
    """Return what a matcher decides of an image."""
    return matcher.assign(tracks, matcher.gate(tracks, seen, now, _silent), len(seen.index), now)


def test_a_near_miss_is_a_free_box_just_outside_the_gate_of_a_robot_without_one():
    squared = np.array([
        [1.0, 80.0, 400.0],  # has box 0
        [50.0, 70.0, 90.0],  # box 1 lies just outside its gate (up to 81)
        [2.0, 100.0, 300.0],  # only box 0 is near, and that is taken
    ])  # fmt: skip
    rows, columns = np.divmod(np.arange(9), 3)
    offsets = np.column_stack([np.sqrt(squared.ravel()), np.zeros(9)])
    pairs = PairInnovations(rows, columns, offsets, np.tile(np.eye(2), (9, 1, 1)))
    joint = _joint(pairs)
    tracks = [Track("aqua", 0, 9, State.COASTING, f"aqua_{i}", (9,)) for i in range(3)]
    seen = boxes(3)
    found = decided(Matcher(joint, 9.0, 2.0), tracks, seen, 10)
    assert (found.matched, found.outside) == (1, 1)


@pytest.mark.parametrize(
    ("stray", "began", "hits", "taken"),
    [
        (0, None, (), [(0, 0)]),
        (20, None, (), []),
        (20, 8, (8,), [(0, 0)]),
        (20, 6, (6, 7), [(1, 0)]),
        (20, 5, (5,), [(1, 0)]),
    ],
    ids=["clean images", "one box", "a second box", "seen beside", "began before it was missed"],
)
def test_a_robot_swerves_with_two_boxes_where_one_may_be_false(stray, began, hits, taken):
    """A robot last seen at 7 without a box, and a box 1 m beside it, far outside its gate.

    A fifth of the robots were missed. Where 20 of 120 had a false box beside their gates, which
    are a fifteenth as wide as where it may have swerved to, this may be one: odds of
    0.2 / 0.8 * 20 / 120 / 8 * 15 = 0.08. Where it goes on a track that began when the robot was
    seen no more, the robot has swerved and takes it.
    """
    robot = Track("aqua", 0, 7, State.COASTING, "aqua_1", (6, 7))
    tracks, offsets = [robot], [(1.0, 0.0)]
    if began is not None:
        tracks.append(Track("aqua", began, max(hits), State.TENTATIVE, "", tuple(hits)))
        offsets.append((0.05, 0.0))
    every = np.arange(len(tracks))
    pairs = PairInnovations(
        every,
        np.zeros_like(every),
        np.array(offsets),
        np.tile(0.01 * np.eye(2), (len(every), 1, 1)),
    )
    joint = _joint(pairs, speed=0.75)
    seen = boxes(1)
    matcher = Matcher(joint, 11.6, 2.0)
    for _ in range(99):
        matcher.clutter.update(0, 1, 0, 0, 0, [GATE])
    matcher.clutter.update(8, 20, 20, stray, stray)
    found = decided(matcher, tracks, seen, 9)
    assert list(zip(found.rows.tolist(), found.columns.tolist(), strict=True)) == taken
    assert found.manoeuvred == ([0] if (0, 0) in taken else [])


@pytest.mark.parametrize(
    ("stray", "unseen_s", "image_s", "taken"),
    [
        (0, 1.5, 0.1, True),
        (1, 1.5, 0.1, True),
        (15, 0.4, 0.1, True),
        (15, 1.5, 0.1, False),
        (15, 1.5, 0.5, True),
    ],
    ids=["clean images", "rare clutter", "missed for a moment", "gone", "gone for three images"],
)
def test_one_box_in_a_wide_gate_is_not_the_robots_where_it_may_be_false(
    stray, unseen_s, image_s, taken
):
    """A gate 100 times as wide as others; of 100 robots 20 were missed, and 15 had clutter near."""
    second = 1_000_000_000
    now = 1000 * second
    left = now - round(unseen_s * second)
    joint = _joint(
        PairInnovations(np.zeros(1, int), np.zeros(1, int), np.array([[1.0, 0.0]]), np.eye(2)[None])
    )
    matcher = Matcher(joint, 11.6, 2.0)
    matcher.clutter.update(0, 80, 0, 0, 0, 80 * [GATE])
    matcher.clutter.update(now - round(image_s * second), 20, 20, stray, stray)
    seen = boxes(1)
    robot = Track("aqua", 0, left, State.COASTING, "aqua_1", (left,))
    assert (len(decided(matcher, [robot], seen, now).rows) == 1) == taken


def test_empty_images_are_images_too():
    """Otherwise images seem seconds apart when the view is empty, and one box may do anything."""
    nothing = boxes(0)
    matcher = Matcher(SimpleNamespace(), 11.6, 2.0)
    assert matcher.gate([], nothing, 5, _silent) is None
    assert matcher.clutter.stamp_ns == 5


def _image(inside, leaving=(), now=1_000_000_000):
    """Return tracks, pairs and boxes of an image: one box for each track, in its gate or not."""
    tracks = [
        Track(
            "aqua",
            0,
            now - 1,
            State.CONFIRMED,
            f"aqua_{i}",
            (now - 1,),
            leaving_view=i in leaving,
        )
        for i in range(len(inside))
    ]
    every = np.arange(len(inside))
    offsets = [[0.0 if one else 9.0, 0.0] for one in inside]
    pairs = PairInnovations(
        every, every, np.array(offsets), np.tile(np.eye(2), (len(inside), 1, 1))
    )
    return tracks, pairs, boxes(len(inside)), now


@pytest.mark.parametrize(
    ("images", "confused"),
    [
        ([[False]], False),  # one alone cannot outvote telemetry
        ([[False, False]], True),
        ([[True, False]], False),
        ([[True, False, False]], True),
        ([[True, True, False]], False),
        ([[False, False, False], [True, True, True]], False),
        ([[False, False, False], [True, False]], True),
        ([[False, False, False], [True, True]], True),  # two boxes may be there by chance
        ([[False, False, False], [True, True], [True, True]], False),
        ([[False, False, False], [True], [True]], True),
        ([[False, False, False], [True], [True], [True]], False),
        ([[False, False, False], [True], [False], [True], [True]], True),
    ],
)
def test_images_are_believed_again_when_robots_are_where_they_should_be(images, confused):
    joint = _joint(None)
    matcher = Matcher(joint, 9.0, 2.0)
    for inside in images:
        tracks, pairs, seen, now = _image(inside)
        joint.compare = lambda *_, pairs=pairs: pairs
        found = decided(matcher, tracks, seen, now)
        assert found.rows.tolist() == found.claimed
    assert matcher.mismatch.active is confused


@pytest.mark.parametrize(("apart", "chosen"), [(2.3, [0, 1]), (1.5, [1, 0])])
def test_positions_outweigh_a_picture_that_shows_robots_exchanged(apart, chosen):
    """Two robots and boxes where they are, or exchanged by squared distances of 13 or 6 each."""
    rows, columns = np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1])
    offsets = np.array([[0.0, 0.0], [apart, 0.0], [-apart, 0.0], [0.0, 0.0]])
    spread = np.tile(0.4 * np.eye(2), (4, 1, 1))
    joint = _joint(PairInnovations(rows, columns, offsets, spread))
    # Boxes' own errors count once for both pairs of a box.
    joint.compare_jointly = lambda *_: np.kron(np.equal.outer(columns, columns), 0.4 * np.eye(2))
    now = 1_000_000_000
    tracks = [Track("aqua", 0, now - 1, State.CONFIRMED, f"aqua_{i}", (now - 1,)) for i in range(2)]
    matcher = Matcher(joint, 14.0, 2.0)
    candidates = matcher.gate(tracks, boxes(2), now, lambda: 100.0 * np.eye(2))
    assert [columns[k] for k in sorted(candidates.given, key=lambda k: rows[k])] == chosen


@pytest.mark.parametrize(
    ("unseen_s", "apart", "beside", "confused"),
    [
        (0.0, 0.0, False, False),
        (5.0, 0.0, False, True),  # something else may be there by now
        (0.0, 9.0, False, True),  # outside the gates
        (0.0, 0.0, True, True),  # boats that have been seen beside them
    ],
)
def test_robots_whose_boxes_have_another_class_are_not_missing(unseen_s, apart, beside, confused):
    """They get no box, but the pose is believed."""
    tracks, pairs, seen, now = _image([True] * 3)
    for track in tracks:
        track.last_seen_ns -= round(unseen_s * 1e9)
    pairs.offsets[:, 0] = apart
    if beside:
        tracks += [Track("boat", now - 1, now - 1, hits=(now - 1,)) for _ in range(3)]
        pairs = PairInnovations(
            np.arange(6), np.tile(pairs.columns, 2), np.tile(pairs.offsets, (2, 1)),
            np.tile(pairs.spread, (2, 1, 1)),
        )  # fmt: skip
    seen.class_ids[:] = "boat"
    matcher = Matcher(_joint(pairs), 9.0, 10.0)
    found = decided(matcher, tracks, seen, now)
    assert not found.claimed
    assert matcher.mismatch.active is confused


def test_robots_that_left_the_picture_are_not_missing():
    tracks, pairs, seen, now = _image([True, False, False], leaving=(1, 2))
    joint = _joint(pairs)
    matcher = Matcher(joint, 9.0, 2.0)
    found = decided(matcher, tracks, seen, now)
    assert (found.rows.tolist(), found.sentence) == ([0], "")
    assert not matcher.mismatch.active


def test_one_image_may_be_in_error_the_second_is_reported_once():
    joint = _joint(None)
    matcher = Matcher(joint, 9.0, 2.0)
    said = []
    images = [[False] * 3, [False] * 3, [False] * 3, [True] * 3, [False] * 3, [False] * 3]
    for k, inside in enumerate(images):
        tracks, pairs, seen, now = _image(inside, now=1_000_000_000 + 200_000_000 * k)
        joint.compare = lambda *_, pairs=pairs: pairs
        said.append(bool(decided(matcher, tracks, seen, now).sentence))
    assert said == [0, 1, 0, 0, 0, 1]


def test_the_box_of_a_robot_that_leaves_is_no_other_robots():
    tracks, pairs, seen, now = _image([True, False, False], leaving=(0,))
    joint = _joint(pairs)
    seen = boxes(2)
    kept = pairs.columns < 2  # the third robot has no box
    pairs = PairInnovations(*(one[kept] for one in vars(pairs).values()))
    joint.compare = lambda *_: pairs
    matcher = Matcher(joint, 9.0, 2.0)
    decided(matcher, tracks, seen, now)
    assert not matcher.mismatch.active


def test_what_is_decided_changes_no_track():
    """A robot far off again and again, a new track beside its box, and one with a box."""
    now = 1_000_000_000
    tracks = [
        Track("aqua", 0, now - 1, State.CONFIRMED, "aqua_1", (now - 1,)),
        Track("aqua", 0, now - 1, hits=(now - 2,)),
        Track("aqua", 0, now - 1, hits=(now - 3,)),
    ]
    offsets = np.array([[2.5, 0.0], [6.0, 0.0], [0.5, 0.0]])
    pairs = PairInnovations(
        np.arange(3), np.array([0, 1, 2]), offsets, np.tile(np.eye(2), (3, 1, 1))
    )
    before = [replace(track) for track in tracks]
    found = decided(Matcher(_joint(pairs, speed=0.8), 9.0, 2.0), tracks, boxes(3), now)
    assert tracks == before
    assert found.near_misses == {1}
    assert found.clutter_shares == {2: pytest.approx(chance_probability(1, 2))}


@pytest.mark.parametrize(
    ("speed", "log_odds", "mismatch"),
    [(4.0, -10.0, False), (4.0, -1.0, True), (0.5, -10.0, True)],
    ids=["manoeuvres", "perhaps a rotation", "too far for manoeuvres"],
)
def test_robots_that_manoeuvre_all_at_once_are_no_mismatch(speed, log_odds, mismatch):
    """Three boxes 5 m off, each its own way, with gates of 3 m and unnoticed manoeuvres of 2 m."""
    tracks, _, seen, now = _image([False] * 3)
    every, offsets = np.arange(3), np.array([[5.0, 0.0], [0.0, 5.0], [-5.0, 0.0]])
    joint = _joint(PairInnovations(every, every, offsets, np.tile(np.eye(2), (3, 1, 1))), speed)
    joint.turned_by = lambda *_: log_odds
    matcher = Matcher(joint, 9.0, 2.0)
    decided(matcher, tracks, seen, now)
    assert matcher.mismatch.active is mismatch


@pytest.mark.parametrize(
    ("offset", "doubtful"),
    [(None, False), (4.0, True), (1.0, False)],
    ids=["missed", "missed, a box beside", "seen"],
)
def test_clutter_is_told_by_boxes_beside_robots_that_are_missed(offset, doubtful):
    """Robots that are only missed have wide gates all the same, ten times as wide as usual."""
    tracks, pairs, _, now = _image([True] * 3)
    shown = 2 if offset is None else 3
    pairs.offsets[2] = offset or 0.0, 0.0
    joint = _joint(PairInnovations(*(one[:shown] for one in vars(pairs).values())))
    matcher = Matcher(joint, 9.0, 2.0)
    for _ in range(20):
        decided(matcher, tracks, boxes(shown), now)
    wide = np.array([2.0 * math.log(10.0)])
    assert matcher.clutter.doubtful(wide).tolist() == [doubtful]
