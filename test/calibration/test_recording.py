# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A recording keeps what it is sent, and gives poses at any time."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.values.rejection import Input

sys.path.insert(0, str(Path(__file__).parent))

from flights import experiment, record


@pytest.fixture(scope="module")
def made():
    """Return six seconds of a flight without errors."""
    return experiment("transit", 0.0, 2, noise="none", duration_s=6.0)


def test_poses_are_those_of_the_flight(made):
    recording = record(made)
    start = made.frames()[0]
    for t in (1.0, 2.5, 4.0):
        ns = start.stamp_ns + round((t - start.t) * 1e9)
        pose, true = recording.pose(ns), made.flight.sample(t)
        assert pose.position[2] == pytest.approx(true.camera[0, 2], abs=0.02)
        assert pose.rotation == pytest.approx(true.enu_from_camera[0], abs=2e-3)
    steps = [recording.pose(start.stamp_ns + round(s * 1e9)).position for s in (1.0, 2.0)]
    way = made.flight.sample(np.array([start.t + 1.0, start.t + 2.0])).camera
    assert steps[1][:2] - steps[0][:2] == pytest.approx(way[1, :2] - way[0, :2], abs=0.05)


def test_where_telemetry_lacks_there_is_no_pose(made):
    recording = record(made)
    first, last = (recording.stamps[Input.FIX][i] for i in (0, -1))
    assert recording.pose(first - 10**9) is None
    assert recording.pose(last + 10**9) is None
    empty = type(recording)(estimator_config({}))
    assert empty.pose(first) is None
    assert empty.camera(first) is None


def test_it_estimates_nothing_and_keeps_boxes_that_are_not_refused(made):
    config = estimator_config({"detections.min_score": 0.5})
    recording = record(made, config)
    frames = list(recording.frames.values())
    assert len(frames) == len(list(made.detections()))
    assert min(one.scores.min() for one in frames if len(one)) >= 0.5
    assert recording.advance(0) == recording.flush() == []
    assert recording.camera(frames[0].stamp_ns) is made.camera
    assert recording.depths(frames[0]).tolist() == [0.0] * len(frames[0])
