# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes correct the tracks that they are assigned to; the others start tracks."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.tracker.image_evidence import TUNING as IMAGE_EVIDENCE
from aerial_gnss_ros.core.tracker.image_update import Assigned, ImageUpdate

BOXES = SimpleNamespace(stamp_ns=7)
SEEN = SimpleNamespace(index=np.array([2, 4, 5]))
RULE = SimpleNamespace(window_ns=2_000_000_000)
COST = np.array([[0.0, 0.0], [IMAGE_EVIDENCE.excluded_cost, 0.0], [0.0, 9.2]])


def updating(tracks=(), impossible=(), swaps=()):
    """Return the update of an image, and a record of what is done."""
    done = []

    def start(_seen, measured, used, _boxes):
        done.append(("start", sorted(used.tolist())))
        measured[9] = 5

    table = SimpleNamespace(
        tracks=list(tracks),
        update=lambda _, rows, *__: done.append(("update", rows.tolist())) or (impossible, 1),
        start=start,
        note_innovations=lambda *_: done.append("innovations"),
        apply=lambda *_: done.append("applied"),
    )
    encounters = SimpleNamespace(update=lambda _, __, columns, *___: (columns, swaps))
    evidence = SimpleNamespace(blind=False, cost=lambda *_: COST)
    recovery = SimpleNamespace(update=lambda rows, *of: done.append((rows.tolist(), *of)))
    matcher = SimpleNamespace(gate=lambda *_: None)
    return ImageUpdate(table, matcher, encounters, evidence, recovery, RULE), matcher, done


def test_without_candidates_nothing_is_assigned():
    made, matcher, done = updating()
    rows, columns, cost = made.assign(SEEN, BOXES)
    assert (len(rows), len(columns), cost, done) == (0, 0, None, [])
    assert matcher.fresh_s == 2.0


def test_what_is_decided_beside_the_assignment_is_applied():
    made, matcher, done = updating()
    decided = SimpleNamespace(rows=np.array([1]), columns=np.array([0]))
    candidates = SimpleNamespace(doubtful=False)
    matcher.gate, matcher.assign = lambda *_: candidates, lambda *_: decided
    assert made.assign(SEEN, BOXES) == (decided.rows, decided.columns, None)
    assert done == ["innovations", "applied"]


@pytest.mark.parametrize(("doubtful", "blind"), [(True, False), (False, True)])
def test_in_doubt_the_picture_is_asked(doubtful, blind):
    made, matcher, _ = updating()
    made._evidence.blind = blind
    decided = SimpleNamespace(rows=np.array([1, 2]), columns=np.array([0, 1]))
    candidates = SimpleNamespace(doubtful=doubtful)
    matcher.gate, matcher.assign = lambda *_: candidates, lambda *_: decided
    rows, columns, cost = made.assign(SEEN, BOXES)
    assert (rows.tolist(), columns.tolist()) == ([2], [1])
    assert cost is COST


@pytest.mark.parametrize("impossible", [[], [3]])
def test_boxes_correct_tracks_unless_they_imply_an_impossible_speed(impossible):
    made, _, done = updating(impossible=impossible)
    measured, refused = made.correct(SEEN, BOXES, Assigned(np.array([0, 3]), np.array([1, 0])), 0.1)
    used = {0: 4} if impossible else {0: 4, 3: 2}
    assert measured == used | {9: 5}
    assert refused.tolist() == ([2] if impossible else [])
    # Also a refused one starts no other track.
    assert done == [("update", [0, 3]), ([*used], 1, 7, 0.1), ("start", [0, 1])]


def test_where_all_boxes_are_assigned_no_track_starts():
    made, _, done = updating()
    measured, _ = made.correct(SEEN, BOXES, Assigned(np.arange(3), np.arange(3)), 0.1)
    assert measured == {0: 2, 1: 4, 2: 5}
    assert done[-1] == ([0, 1, 2], 1, 7, 0.1)


def test_labels_that_association_had_exchanged_are_exchanged():
    tracks = [Track("aqua", 0, 0, robot_id=name) for name in ("a", "b")]
    made, _, _ = updating(tracks, swaps=[(0, 1)])
    made.correct(SEEN, BOXES, Assigned(np.arange(2), np.arange(2)), 0.1)
    assert [track.robot_id for track in tracks] == ["b", "a"]
