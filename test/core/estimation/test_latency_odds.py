# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How likely another latency is than the configured one, and when all others are ruled out."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation import latency_odds
from aerial_gnss_ros.core.estimation.latency_odds import LatencyOdds
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers

BEFORE = math.log(1.0 / 9.0)
LATE = np.array([-1.0, -0.2, 0.0, 0.2, 1.0])


def odds(least, most, sigma_s=0.0):
    """Return odds of which every image tells the same, and what the cover was told."""
    config = estimator_config({"noise.latency_s": 1.0})
    made, told = LatencyOdds(config, TelemetryBuffers(config)), []
    evidence = SimpleNamespace(bounds=lambda: (np.array(least), np.array(most)), configured=2)
    made.search = SimpleNamespace(
        compare=lambda *_: None, evidence=evidence, corrections=LATE, stamp_sigma_s=sigma_s
    )
    made.cover = SimpleNamespace(weigh=told.append)
    return made, told


def image(second):
    """Return an image of a camera that moves by 1 m/s."""
    pose = MapPose(np.array([float(second), 0.0, 30.0]), np.eye(3))
    return SimpleNamespace(detections=SimpleNamespace(stamp_ns=second * 1_000_000_000), in_map=pose)


@pytest.mark.parametrize(
    ("gains", "nats"),
    [
        ([0.0] * 4, BEFORE),
        ([-3.0] * 4, BEFORE - 3.0),
        ([8.0, -60.0, -60.0, -60.0], BEFORE + 8.0 - math.log(4.0)),  # of four as likely before
    ],
)
def test_all_other_latencies_together_are_weighed(gains, nats):
    assert latency_odds._log_odds(np.array(gains)) == pytest.approx(nats)


@pytest.mark.parametrize(
    ("most", "ruled_out"),
    [
        ([-3.1, 0.0, 0.0, 0.0, -3.1], True),  # what is 0.2 s apart takes long to tell
        ([-3.1, 0.0, 0.0, 0.0, -2.9], False),
        ([-2.9, -9.0, 0.0, -9.0, -9.0], False),
    ],
)
def test_others_are_ruled_out_by_the_greater_and_likely_by_the_lesser(most, ruled_out):
    made, told = odds([-5.0, -5.0, 0.0, -5.0, -5.0], most)
    made.update(image(0), {}, None)
    assert made.ruled_out is ruled_out
    np.testing.assert_array_equal(told[0], np.clip(0.0, [-5.0, -5.0, 0.0, -5.0, -5.0], most))
    assert made.nats == pytest.approx(BEFORE - 5.0)


def test_telemetry_with_stamps_of_images_is_late_for_certain():
    made, _ = odds([-9.0] * 5, [-9.0] * 5, sigma_s=0.3)
    made.update(image(0), {}, None)
    assert made.nats == math.inf


def test_images_are_taken_more_seldom_after_long_motion():
    made, _ = odds([0.0] * 5, [0.0] * 5)
    paused = []
    for second in range(63):
        made.update(image(second), {}, None)
        paused.append(made.motion.pause_s)
    assert paused == [0.4] * 61 + [1.0] * 2
