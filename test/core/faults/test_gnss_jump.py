# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A position that jumps is believed when it has stayed, and at once when it is back."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.core.faults.gnss_jump import GnssJumpDetector
from aerial_gnss_ros.core.values.events import Events


def fly(easts):
    """Positions each 0.1 s of a drone that hovers, but for jumps; what each image was told."""
    jumps, place, told = GnssJumpDetector(Events()), 0.0, []
    for east in easts:
        now = np.array([east, 0.0, 20.0])
        settled, jump = jumps.update(now, np.array([place, 0.0, 20.0]), 0.1)
        place += 0.0 if jump is None else jump[0]
        told.append((settled, 0.0 if jump is None else float(jump[0]), jumps.returned))
    return told


def test_a_jump_that_stays_is_believed_after_three_seconds():
    told = fly([0.0] * 3 + [50.0] * 35)
    assert told[:3] == [(True, 0.0, False)] * 3
    assert [settled for settled, _, _ in told[3:33]] == [False] * 30
    assert told[33] == (True, 50.0, False)
    assert told[34:] == [(True, 0.0, False)] * 4


def test_the_way_back_is_believed_at_once():
    told = fly([0.0] * 3 + [50.0] * 35 + [0.0] * 3)
    assert told[38] == (True, -50.0, True)
    assert told[39][:2] == (True, 0.0)


def test_another_jump_is_not_the_way_back():
    told = fly([0.0] * 3 + [50.0] * 35 + [100.0] * 3)
    assert [settled for settled, _, _ in told[38:]] == [False] * 3
    assert fly([0.0] * 3 + [50.0] * 5 + [0.0] * 3)[9] == (True, 0.0, False)


def test_it_says_when_positions_leave_and_how_far_they_are():
    jumps, told = GnssJumpDetector(Events()), []
    for east, expected in [(0.0, 0.0), (50.0, 0.0), (50.0, 0.0)]:
        jumps.update(np.array([east, 0.0, 20.0]), np.array([expected, 0.0, 20.0]), 2.0)
        told.append((jumps.began, float(jumps.believed[0])))
    jumps.update(np.array([50.0, 0.0, 20.0]), np.array([0.0, 0.0, 20.0]), 2.0)
    assert [*told, float(jumps.believed[0])] == [(False, 0.0), (True, 0.0), (False, 0.0), 50.0]
    jumps.update(np.array([100.0, 0.0, 20.0]), np.array([50.0, 0.0, 20.0]), 2.0)
    assert not jumps.began  # they had left before
    jumps.update(np.array([0.0, 0.0, 20.0]), np.array([50.0, 0.0, 20.0]), 2.0)
    assert jumps.returned
    assert not jumps.believed.any()
