# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots coast for as long as their class may, other tracks for a window; then they are lost."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from aerial_gnss_ros.core.association.track import EarlierLabel, Track
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.tracker.coasting import Coasting
from aerial_gnss_ros.core.values.estimates import State

SECOND = 1_000_000_000
WINDOW_S, COAST_S = 2, 20


def coasting(*tracks, missing=False, **values):
    """Return what lets tracks coast, and the tracks without a label that it has seen to end."""
    ended = []
    confirmation = SimpleNamespace(
        rule=SimpleNamespace(window_ns=WINDOW_S * SECOND),
        robots_missing=lambda _: missing,
        transients=SimpleNamespace(note=lambda *of: ended.append(of)),
    )
    config = estimator_config({"tracks.coast_s": float(COAST_S)} | values)
    table = SimpleNamespace(tracks=list(tracks))
    return Coasting(table, confirmation, config), ended


def robot(class_id="aqua", last_s=0, **values):
    return Track(class_id, 0, last_s * SECOND, State.CONFIRMED, "aqua_1", **values)


@pytest.mark.parametrize(("unseen_s", "lost"), [(COAST_S, set()), (COAST_S + 1, {0})])
def test_a_robot_coasts_until_it_is_lost(unseen_s, lost):
    track = robot()
    assert coasting(track)[0].update(unseen_s * SECOND) == lost
    assert track.state is (State.LOST if lost else State.COASTING)


@pytest.mark.parametrize("missing", [False, True])
def test_a_track_without_a_label_ends_with_the_window_and_counts_unless_robots_are_missing(missing):
    track = Track("aqua", 0, 0, clutter_probability=0.25, score_count=2)
    made, ended = coasting(track, missing=missing)
    assert made.update(WINDOW_S * SECOND) == set()
    assert track.state is State.TENTATIVE
    assert made.update(WINDOW_S * SECOND + 1) == {0}
    assert track.state is State.LOST
    assert ended == ([] if missing else [(WINDOW_S * SECOND + 1, 0.75)])


def test_robots_stay_while_one_of_them_may_have_come_back_under_a_pending_label():
    came = Track("aqua", 15 * SECOND, 25 * SECOND, label_pending=True)
    assert coasting(robot(), came)[0].update(25 * SECOND) == set()
    assert coasting(robot(), came)[0].update(28 * SECOND) == {1}
    assert coasting(robot())[0].update(25 * SECOND) == {0}


def test_a_class_may_coast_for_another_time_and_that_may_change():
    buoy = {"classes.buoy.coast_s": 5.0}
    made, _ = coasting(robot("buoy"), **buoy)
    assert made.update(5 * SECOND) == set()
    assert made.update(6 * SECOND) == {0}
    made.reconfigure(estimator_config({"classes.buoy.coast_s": 7.0}))
    assert made.update(6 * SECOND) == set()


@pytest.mark.parametrize(("came_s", "lost"), [(COAST_S - 1, set()), (COAST_S + 1, {0})])
def test_a_robot_stays_while_a_track_with_a_new_label_may_be_it(came_s, lost):
    """If it would have coasted when that track came, and for `coast_s` from then on."""
    heir = robot(last_s=COAST_S + 2, may_be={"aqua_1": EarlierLabel(0.0, 1.0, 1.0, 0.0)})
    heir.robot_id, heir.first_seen_ns = "aqua_2", came_s * SECOND
    made = coasting(robot(), heir)[0]
    assert made.update((COAST_S + 2) * SECOND) == lost
    heir.last_seen_ns = (2 * COAST_S + 2) * SECOND
    assert 0 in made.update(heir.last_seen_ns)
