# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Types of messages, and by which clock they are stamped."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from aerial_gnss_ros.adapters.kinds import ATTITUDE, FIX, GIMBAL, HEIGHT, stamp_ns

MESSAGE = SimpleNamespace(
    header=SimpleNamespace(stamp=SimpleNamespace(sec=5, nanosec=7)), timestamp=3, timestamp_sample=2
)


@pytest.mark.parametrize(
    ("clock", "ns"), [("arrival", 11), ("header", 5_000_000_007), ("px4_us", 3_000)]
)
def test_a_message_is_stamped_by_the_clock_that_is_named(clock, ns):
    assert stamp_ns(MESSAGE, 11, clock) == ns


@pytest.mark.parametrize("kinds", [FIX, ATTITUDE, GIMBAL, HEIGHT])
def test_topics_of_px4_and_no_others_may_have_a_version(kinds):
    for name, kind in kinds.items():
        assert kind.versioned is name.startswith("px4_")
        assert kind.versioned is kind.msgtype.startswith("px4_msgs/msg/")
