# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether robots tell a jump: odds of 20 to 1 between two copies, and nothing stays changed."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from aerial_gnss_ros.core.tracker.gnss_jump_test import robots_tell_jump

FRAME = SimpleNamespace(detections=SimpleNamespace(stamp_ns=7))


class Table:
    """Robots whose boxes fit by so many nats, if the position has not jumped and if it has."""

    def __init__(self, stays, jumped):
        self.nats = {False: stays, True: jumped}
        self.filter = self
        self.told = None

    def update_camera(self, _frame, robots_tell):
        """Take in a pose."""
        self.told = robots_tell()

    def misfit(self, seen, stamp_ns, threshold):
        """Return how badly boxes fit."""
        assert (seen, stamp_ns, threshold) == ("boxes", 7, 9.0)
        return self.nats[self.told]


@pytest.mark.parametrize(("more", "told"), [(0.01, True), (-0.01, False), (-50.0, False)])
def test_boxes_must_fit_a_jump_better_by_odds_of_20_to_1(more, told):
    table = Table(math.log(20.0) + more + 3.0, 3.0)
    assert robots_tell_jump(table, FRAME, "boxes", 9.0) is told
    assert table.told is None  # copies took in the image
