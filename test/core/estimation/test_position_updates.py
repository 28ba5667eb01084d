# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Samples for other filters: far enough apart, wide enough, and only of robots that are seen."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.config.processing import UpdatesConfig
from aerial_gnss_ros.core.estimation.position_updates import SECOND_NS, PositionUpdates
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate, State

TIME_S = 300.0


def result(t, state=State.CONFIRMED, name="aqua_1"):
    stamp = round(t * SECOND_NS)
    seen = RobotEstimate(
        stamp, name, "aqua", state, 0.2, -1.0, 3.0, np.zeros(2), np.zeros(2), np.eye(4), stamp
    )
    return FrameResult(stamp, "camera", (seen,), (), None)


def given(updates, times, **more):
    return [t for t in times if updates.due(result(t, **more))]


def test_samples_are_three_correlation_times_apart():
    updates = PositionUpdates(UpdatesConfig(), TIME_S)
    assert given(updates, range(2000)) == [5, 905, 1805]
    [sample] = PositionUpdates(UpdatesConfig(settle_s=0.0), TIME_S).due(result(0.0))
    shared = math.exp(-3.0)
    assert sample.covariance == pytest.approx(np.eye(4) * (1 + shared) / (1 - shared))


def test_white_errors_are_independent_after_half_a_minute_and_not_widened():
    updates = PositionUpdates(UpdatesConfig(), 0.0)
    assert (updates.interval_s, updates.factor) == (30.0, 1.0)


def test_a_robot_must_be_seen_for_some_seconds_and_again_after_a_dive():
    updates = PositionUpdates(UpdatesConfig(interval_s=30.0), TIME_S)
    assert given(updates, [0, 1, 2, 3, 4]) == []
    assert given(updates, [20, 21, 22, 23, 24, 25, 26]) == [25]
    assert given(updates, [60, 64, 64.9]) == []


def test_no_prediction_is_a_sample_and_robots_are_apart():
    updates = PositionUpdates(UpdatesConfig(settle_s=0.0), TIME_S)
    assert given(updates, range(10), state=State.COASTING) == []
    assert given(updates, [10]) == [10]
    assert given(updates, [11], name="aqua_2") == [11]


def test_a_recording_that_begins_anew_gives_samples_again():
    updates = PositionUpdates(UpdatesConfig(), TIME_S)
    assert given(updates, range(1000, 1010)) == [1005]
    assert given(updates, range(20)) == [5]


@pytest.mark.parametrize("interval_s", [30.0, 300.0, math.nan])
def test_the_mean_of_many_samples_is_as_good_as_their_covariance_says(interval_s):
    """Gauss-Markov errors, averaged as if independent: NEES of the mean is 2."""
    updates = PositionUpdates(UpdatesConfig(interval_s=interval_s, settle_s=0.0), TIME_S)
    rng = np.random.default_rng(1)
    kept = math.exp(-updates.interval_s / TIME_S)
    count, flights = round(60 * TIME_S / updates.interval_s), 1000
    error = rng.normal(size=(flights, 2))
    mean = np.zeros((flights, 2))
    for _ in range(count):
        mean += error / count
        error = kept * error + math.sqrt(1 - kept**2) * rng.normal(size=error.shape)
    nees = (mean**2).sum(axis=1) / (updates.factor / count)
    assert nees.mean() == pytest.approx(2.0, abs=0.3)
