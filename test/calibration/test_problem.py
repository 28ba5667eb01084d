# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which images a fit uses."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from aerial_gnss_ros.calibration.motion import Motion
from aerial_gnss_ros.calibration.problem import LIMIT_S, MARGIN_S, Problem
from aerial_gnss_ros.calibration.search import Search

sys.path.insert(0, str(Path(__file__).parent))

from flights import experiment, record


def test_latencies_are_compared_on_the_same_images() -> None:
    """At 3 s the first images of a recording have no telemetry, and at -3 s the last."""
    recording = record(experiment("orbit", 0.0, 5))
    search, motion = Search(recording, False), Motion(recording)
    every = Problem(recording, motion, 240)
    linked = [every.evidence(late, 0.0) for late in (-LIMIT_S, LIMIT_S)]
    assert all(one is not None and one.share < 0.95 for one in linked)
    for problem in (search.compared, search.coarse):
        linked = [problem.evidence(late, 0.0) for late in (-LIMIT_S, 0.0, LIMIT_S)]
        assert [one.share for one in linked if one is not None] == [1.0, 1.0, 1.0]
    first, last = every.stamps_ns[[0, -1]]
    margin_ns = round((LIMIT_S + MARGIN_S - 1.6) * 1e9)  # telemetry begins a second before images
    assert search.compared.stamps_ns[0] > first + margin_ns
    assert search.compared.stamps_ns[-1] < last - margin_ns
    np.testing.assert_array_equal(search.fine.stamps_ns, every.stamps_ns)


def test_a_short_recording_is_compared_on_all_its_images() -> None:
    search = Search(record(experiment("orbit", 0.0, 5, duration_s=12.0)), False)
    assert search.compared is search.fine
