# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether robots indicate a jump: odds of 20 to 1 between two copies, which leave no trace."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.tracker.gnss_jump_test import robots_tell_jump

FRAME = SimpleNamespace(detections=SimpleNamespace(stamp_ns=7))
SEEN, EMPTY = SimpleNamespace(index=[0, 1]), SimpleNamespace(index=[])
SEEN.moved = lambda step: SimpleNamespace(moved=float(step[0]))


class Table:
    """Robots whose boxes fit by so many nats, if the position has not jumped and if it has."""

    def __init__(self, stays, jumped, label="aqua_1", rows=(0,)):
        self.nats = {False: stays, True: jumped}
        self.tracks, self.rows = [SimpleNamespace(robot_id=label)], list(rows)
        self.filter = self
        self.reported = None

    def update_camera(self, _frame, robots_tell):
        """Take in a pose."""
        self.reported = robots_tell()

    @property
    def trajectory(self):
        """Where the receiver is from the place that is used."""
        return SimpleNamespace(jumps=SimpleNamespace(offset=np.array([4.0 * self.reported, 0, 0])))

    def in_view(self, stamp_ns):
        """Return the robots that the image is expected to show."""
        assert stamp_ns == 7
        return self.rows

    def misfit(self, seen, stamp_ns, threshold):
        """Return how badly boxes fit."""
        assert (seen.moved, stamp_ns, threshold) == (-4.0 * self.reported, 7, 9.0)
        return self.nats[self.reported]


@pytest.mark.parametrize(("more", "reported"), [(0.01, True), (-0.01, False), (-50.0, False)])
def test_boxes_must_fit_a_jump_better_by_odds_of_20_to_1(more, reported):
    table = Table(math.log(20.0) + more + 3.0, 3.0)
    assert robots_tell_jump(table, FRAME, SEEN, 9.0) is reported
    assert table.reported is None  # copies took in the image


@pytest.mark.parametrize(("label", "jumped"), [("aqua_1", True), ("", False)])
@pytest.mark.parametrize(("seen", "rows"), [(EMPTY, [0]), (SEEN, [])])
def test_where_no_robot_is_to_be_seen_it_has_jumped(label, jumped, seen, rows):
    """No box, or no robot in view that could be one: those out of sight may be wrong by it."""
    assert robots_tell_jump(Table(0.0, 0.0, label, rows), FRAME, seen, 9.0) is jumped
