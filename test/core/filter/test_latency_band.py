# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Candidates are divided into bands by when their telemetry arrives."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.filter.latency_band import bands


@pytest.mark.parametrize(
    ("first", "last", "found"),
    [
        (-30, 30, [(-10, 30), (-20, -11), (-30, -21)]),
        (-15, 30, [(-10, 30), (-15, -11)]),
        (-10, 5, [(-10, 5)]),
        (0, 30, [(0, 30)]),
    ],
)
def test_each_candidate_is_in_one_band(first, last, found):
    assert bands(first, last) == found
