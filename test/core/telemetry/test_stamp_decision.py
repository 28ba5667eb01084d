# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a decision on stamps is in words."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.telemetry.stamp_decision import Decision


@pytest.mark.parametrize(
    ("decision", "words"),
    [
        (Decision(False, ("fix", "gimbal")), "The clock of fix, gimbal was set"),
        (
            Decision(True, ("fix",), by_ns=86_400_040_000_000),
            "Time went forward by 86400.0 s (fix)",
        ),
        (Decision(True, ("fix",), by_ns=-1_260_000_000), "Time went backward by 1.3 s (fix)"),
    ],
)
def test_a_decision_says_which_way_time_went_and_by_which_inputs(decision, words):
    assert str(decision) == words
