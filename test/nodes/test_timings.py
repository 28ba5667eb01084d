# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Milliseconds per stage, and how long images waited."""

from __future__ import annotations

import math

from aerial_gnss_ros.nodes.timings import Timings, Waits


def test_only_the_last_images_count():
    timings = Timings(remembered=20)
    for value in range(100):
        timings.add({"infer": float(value)} | ({"decode": 1.0} if value % 2 else {}))
    assert timings.samples_ms()["infer"] == [float(value) for value in range(80, 100)]
    assert timings.means_ms() == {"infer": 89.5, "decode": 1.0}
    assert timings.p95_ms() == {"infer": 98.0, "decode": 1.0}  # 19 of 20 took that or less
    timings.remember(1)
    assert timings.means_ms() == {}


def test_waits_are_kept_by_stamp_and_bounded():
    waits = Waits()
    waits.begin(7, 1.0)
    assert waits.end(7, 1.25) == 250.0
    assert math.isnan(waits.end(7, 2.0))
    for stamp in range(10_000):
        waits.begin(stamp, 0.0)
    assert math.isnan(waits.end(0, 1.0))
    assert waits.end(9_999, 1.0) == 1000.0
