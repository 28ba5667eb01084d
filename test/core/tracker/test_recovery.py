# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""When boxes are not where robots can be, and when that is over."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.association.scene_mismatch import SceneMismatch
from aerial_gnss_ros.core.association.track import TUNING as TRACK
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.tracker.fork import TUNING as FORK
from aerial_gnss_ros.core.tracker.fork import Fork
from aerial_gnss_ros.core.tracker.recovery import Recovery
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.rejection import Cause

SECOND = 1_000_000_000


def recovery(*tracks, began=False, returned=False):
    """Return a recovery, its matcher, and a record of calls of the filter."""
    reported = []
    joint = SimpleNamespace(
        trajectory=SimpleNamespace(jumps=SimpleNamespace(began=began, returned=returned)),
        groups=[],
        ambiguity=SimpleNamespace(apart=0.0, covariance=np.zeros((3, 3))),
        update_ambiguity=lambda seconds, over=False: reported.append((seconds, over)),
    )
    table = SimpleNamespace(
        tracks=list(tracks), filter=joint, give_up_unverified=lambda: reported.append("given up"),
        restore=lambda _: reported.append("restored"),
    )  # fmt: skip
    matcher = SimpleNamespace(mismatch=SceneMismatch(), threshold=9.0)
    return Recovery(table, matcher, 9.0), matcher, reported


def robot(label="aqua_1", first_ns=0, last_ns=SECOND):
    return Track("aqua", first_ns, last_ns, State.CONFIRMED, label)


def test_lost_robots_are_reported_with_the_time_until_they_are_back():
    found, matcher, reported = recovery(robot())
    every = np.array([0])
    found.update(every, 0, SECOND, 0.1)
    assert reported == []
    matcher.mismatch.active = True
    found.update(every[:0], 0, 2 * SECOND, 0.1)
    found.update(every[:0], 0, 3 * SECOND, 0.2)
    assert reported == [(0.1, False), (0.2, False)]
    matcher.mismatch.active = False
    found.update(every, 0, 4 * SECOND, 0.1)
    assert reported[2:] == [(0.0, True), "given up"]
    found.update(every, 0, 5 * SECOND, 0.1)
    assert len(reported) == 4


def test_new_robots_do_not_say_that_the_camera_is_right_again():
    found, _, reported = recovery(robot(first_ns=3 * SECOND, last_ns=4 * SECOND))
    found.update(np.zeros(0, np.intp), 1, 2 * SECOND, 0.1)  # no other robot but a refused one
    found.update(np.array([0]), 0, 2 * SECOND + 2 * TRACK.recent_ns, 0.1)
    assert reported == [(0.1, False), (0.0, False)]


@pytest.mark.parametrize(("refused", "lost"), [(1, False), (2, True)])
def test_robots_are_lost_when_as_many_are_refused_as_are_not(refused, lost):
    found, _, reported = recovery(robot(), robot("aqua_2"), robot(""))
    found.update(np.arange(3), refused, SECOND, 0.1)
    assert reported == ([(0.1, False)] if lost else [])


def test_what_it_keeps_is_restored_until_its_robots_can_be_anywhere():
    found, _, reported = recovery(robot())
    found.fork = found._forked(SECOND)
    found.go_back()
    assert reported == ["restored"]
    found.forget_old(2 * SECOND)
    assert found.fork is not None
    found.forget_old(1000 * SECOND)
    assert found.fork is None


def test_what_was_seen_meanwhile_without_a_label_is_given_up():
    meanwhile, waits, now = (robot("", last_ns=one) for one in (1, 1, 9))
    waits.label_pending = True
    found, _, _ = recovery(meanwhile, waits, now, robot(last_ns=1))
    found.reject_unlabelled(9)
    assert [one.rejected for one in found._table.tracks] == [True, False, False, False]
    assert meanwhile.rejection_cause is Cause.LOST_PLATFORM


@pytest.mark.parametrize(
    ("label", "found_after_ns", "over"),
    [
        ("aqua_1", TRACK.recent_ns - 1, True),
        ("aqua_1", TRACK.recent_ns, False),  # it may have been found elsewhere
        ("aqua_2", TRACK.recent_ns - 1, False),  # it was not in view when robots were lost
    ],
    ids=["soon", "late", "long out of view"],
)
def test_robots_found_again_soon_after_they_were_lost_are_old_ones(label, found_after_ns, over):
    lost_ns = 9 * SECOND
    found, matcher, reported = recovery(
        robot("aqua_1", last_ns=lost_ns - TRACK.recent_ns + 1),
        robot("aqua_2", last_ns=lost_ns - TRACK.recent_ns),
    )
    matcher.mismatch.active = True
    found.update(np.zeros(0, np.intp), 0, lost_ns, 0.1)
    found._table.tracks.append(robot(label, first_ns=lost_ns + 1))
    matcher.mismatch.active = False
    found.update(np.array([2]), 0, lost_ns + found_after_ns, 0.1)
    assert reported[1] == (0.0, over)


@pytest.mark.parametrize(("labels", "over"), [(("new",), False), (("aqua_1", "new"), False),
                                              (("aqua_1", "aqua_2", "new"), True)])  # fmt: skip
def test_it_is_over_when_most_robots_in_view_are_old_ones(labels, over):
    found, matcher, reported = recovery(robot("aqua_1", last_ns=SECOND), robot("aqua_2"))
    for track in found._table.tracks:
        track.last_seen_ns = SECOND
    matcher.mismatch.active = True
    found.update(np.zeros(0, np.intp), 0, SECOND, 0.1)
    found._table.tracks += [robot(one, first_ns=SECOND + 1) for one in labels]
    matcher.mismatch.active = False
    found.update(np.arange(2, 2 + len(labels)), 0, SECOND + 2, 0.1)
    assert reported[1] == (0.0, over)


def test_a_fork_ends_after_a_second_without_contradictions_in_a_row():
    found, _, _ = recovery(robot())
    every = np.array([0])
    found.fork = Fork(0, [], [])
    for stamp_ns in (1, 2):
        found.update(every, 0, stamp_ns, 0.6 * FORK.calm_s)
        assert found.fork.holds(stamp_ns) is (stamp_ns == 1)
    found._table.filter.ambiguity.apart = 0.1
    found.update(every, 0, 3, 0.6 * FORK.calm_s)
    assert found.fork.calm_s == 0.0


@pytest.mark.parametrize(
    ("state", "label", "asked"),
    [
        (State.CONFIRMED, "aqua_1", False),
        (State.COASTING, "aqua_1", True),
        (State.CONFIRMED, "", True),
    ],
    ids=["a robot is measured", "it is not", "what is measured has no label"],
)
def test_labels_are_restored_only_while_no_robot_is_measured(state, label, asked):
    found, _, _ = recovery(Track("aqua", 0, 0, state, label))
    reported = []
    found.regrouping = SimpleNamespace(
        are_back=lambda *given, previous: reported.append((*given, previous)) or True,
        restore_labels=lambda: reported.append("restored"),
    )
    found.restore_labels([3], 2)
    assert reported == ([([3], 2, True), "restored"] if asked else [])
