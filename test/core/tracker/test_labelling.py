# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tracks get labels at once, or, while robots are missing, by their formation or later."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from aerial_gnss_ros.core.association.scene_mismatch import SceneMismatch
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.tracker.labelling import Labelling


def labelling(*tracks, ready=(), lasting=(), mismatch=False, regrouped=None, back=False):
    """Return what labels tracks, the matcher, and a record of what it does."""
    done = []
    table = SimpleNamespace(tracks=list(tracks), give_up_unverified=lambda: done.append("given up"))
    matcher = SimpleNamespace(mismatch=SceneMismatch())
    matcher.mismatch.active = mismatch

    def confirm(rows, *_, known):
        done.append((rows, known))
        return {7}

    confirmation = SimpleNamespace(
        ready=lambda _, lasting=False, of=(list(ready), list(lasting)): of[lasting],
        confirm=lambda *given: confirm(*given[:-1], known=given[-1]),
    )
    recovery = SimpleNamespace(
        regroup=lambda _: regrouped,
        restore_labels=lambda *_: done.append("restored"),
        regrouping=SimpleNamespace(are_back=lambda *_: back),
    )
    account = SimpleNamespace(confirm=lambda _: done.append("counted"))
    return Labelling(table, matcher, recovery, confirmation, account), matcher, done


def test_without_a_mismatch_tracks_with_enough_hits_are_labelled_at_once():
    made, matcher, done = labelling(ready=[3], back=False)
    assert made.update(1, 30.0, None, 0) == {7}
    assert done == ["restored", ([3], True), "counted"]
    assert not matcher.mismatch.active
    made, _, done = labelling()
    assert made.update(1, 30.0, None, 0) == set()
    assert done == []


def test_displaced_robots_are_labelled_by_their_formation():
    made, _, done = labelling(ready=[3], mismatch=True, regrouped={1, 2})
    assert made.update(1, 30.0, None, 0) == {1, 2}
    assert done == ["counted"]


@pytest.mark.parametrize("back", [True, False])
def test_during_a_mismatch_robots_that_are_back_are_labelled_and_others_once_they_last(back):
    made, matcher, done = labelling(ready=[3], lasting=[4], mismatch=True, back=back)
    assert made.update(1, 30.0, None, 0) == {7}
    first = [([3], True)] if back else [([4], False)]
    assert done == ["restored", *["given up"] * back, *first, "counted"]
    assert not matcher.mismatch.active


def test_a_mismatch_lasts_until_a_track_has_lasted():
    made, matcher, done = labelling(ready=[3], mismatch=True)
    assert made.update(1, 30.0, None, 0) == set()
    assert (done, matcher.mismatch.active) == (["restored"], True)


def test_rejected_tracks_end_unless_they_have_or_had_a_label():
    tracks = [Track("aqua", 0, 0, rejected=True) for _ in range(3)] + [Track("aqua", 0, 0)]
    tracks[0].robot_id, tracks[1].previous_label = "aqua_1", "aqua_2"
    assert labelling(*tracks)[0].update(1, 30.0, None, 0) == {2}
