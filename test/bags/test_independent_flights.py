# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Flights of another simulation, replayed with default parameters: nobody states what is unusual.

Which robots stay, how large errors are and how long they last is in no message and in no parameter.
Limits leave room: a flight is one draw.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from unstated_errors import fly

pytestmark = pytest.mark.flights

LIMITS = {
    "orbit30_still": (0.08, 1.0, 0.95),
    "transit30_still": (0.15, 1.0, 0.95),
    "hover30_mixed": (0.5, 1.0, 0.95),
    "orbit20_mixed_noisy": (1.8, 2.0, 0.95),
    "orbit40_moving_quiet": (0.6, 1.0, 0.95),
    "transit25_late": (3.0, 1.5, 0.95),
    "orbit60_coloured": (0.5, 1.5, 0.95),
    "orbit30_slow": (1.5, 1.0, 0.9),
}
"""Largest RMS error, m, and NEES/2, and least share of boxes with positions, of the last third."""


@pytest.mark.parametrize("flight", LIMITS)
def test_nothing_needs_to_be_stated(flight, independent_flights):
    found = fly("nothing", independent_flights / flight)
    rms_m, nees, least = LIMITS[flight]
    assert found.positions > least
    assert found.error_m < rms_m
    assert found.nees < nees
