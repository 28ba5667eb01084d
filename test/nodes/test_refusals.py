# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Refused images are counted by reason, and the last one is reported for a while."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.nodes.refusals import RECENT_S, Refusals


@pytest.mark.parametrize(
    ("passed_s", "reported"), [(0.99 * RECENT_S, "it is cut off"), (RECENT_S, "")]
)
def test_the_last_refusal_is_reported_for_ten_seconds(passed_s, reported):
    refusals = Refusals()
    assert refusals.recent(0) == ""
    refusals.add("zeros", "its size is 0.", 0)
    refusals.add("damaged", "it is cut off.", 10**9)
    assert refusals.recent(10**9 + round(passed_s * 1e9)) == reported


def test_refusals_are_counted_by_reason():
    refusals = Refusals()
    for reason in ("size", "damaged", "size"):
        refusals.add(reason, "", 0)
    assert refusals.total == 3
    assert list(refusals.values().items()) == [("refused_damaged", 1), ("refused_size", 2)]
