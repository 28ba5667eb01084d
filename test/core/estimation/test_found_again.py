# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether robots are where they were after the clock of everything was set."""

from __future__ import annotations

from aerial_gnss_ros.core.estimation.found_again import TRIAL_IMAGES, FoundAgain
from aerial_gnss_ros.core.values.estimates import State

SECOND = 1_000_000_000


def test_robots_found_again_or_not(result_at):
    again = FoundAgain()
    before = (
        result_at(0, ["a", "b"]).estimates + result_at(0, ["c"], state=State.COASTING).estimates
    )
    again.expect(before)
    for i in range(100):
        assert not again.failed(result_at(i * SECOND, ["d"], boxes=0))  # nothing to be seen
    assert not again.failed(result_at(100 * SECOND, ["c", "d", "e"], boxes=3))
    assert not again.failed(result_at(103 * SECOND, ["a", "d"], boxes=3))  # half of them
    assert not again.failed(result_at(110 * SECOND, ["d"]))
    again.expect(before)
    reported = [
        again.failed(result_at(i * SECOND, ["d", "c"], boxes=3)) for i in range(TRIAL_IMAGES + 1)
    ]
    assert reported == [False] * (TRIAL_IMAGES - 1) + [True] * 2
    again.expect(before)
    reported = [again.failed(result_at(i * SECOND // 10, ["d"], boxes=3)) for i in range(22)]
    assert reported == [False] * 21 + [True]
