# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Marginal likelihoods of faults, and when they name a drone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.fault import (
    FAULTS,
    TUNING,
    Suspicion,
    culprit,
    log_ratio,
    suspects,
    suspicions,
)


def log_normal(z, spread):
    return -0.5 * (np.linalg.slogdet(2.0 * math.pi * spread)[1] + z @ np.linalg.solve(spread, z))


@pytest.mark.parametrize("measured", [1, 3, 8])
def test_the_ratio_is_that_of_the_marginal_likelihoods(measured):
    rng = np.random.default_rng(measured)
    root = rng.normal(size=(5, 5))
    prior = root @ root.T
    H, noise = rng.normal(size=(measured, 5)), 0.1 * np.eye(measured)
    z = 4.0 * rng.normal(size=measured)
    gain = prior @ H.T @ np.linalg.inv(H @ prior @ H.T + noise)
    mean, covariance = gain @ z, prior - gain @ H @ prior
    wide = prior + 9.0 * np.diag([0.0, 1.0, 0.0, 1.0, 0.0])
    expected = log_normal(z, H @ wide @ H.T + noise) - log_normal(z, H @ prior @ H.T + noise)
    assert log_ratio(mean, covariance, prior, [1, 3], 9.0) == pytest.approx(expected, rel=1e-3)
    gain = wide @ H.T @ np.linalg.inv(H @ wide @ H.T + noise)
    mean, covariance = gain @ z, wide - gain @ H @ wide
    assert log_ratio(mean, covariance, wide, [1, 3], -9.0) == pytest.approx(-expected, rel=1e-3)


def test_what_fails_more_often_is_named_on_less_evidence():
    sensors = {one.probability: one for one in FAULTS}
    often, seldom = sensors[TUNING.turned], sensors[TUNING.probability]
    assert often.sensor == "compass"
    for ratio in (6.0, 7.0, 8.0):
        assert (culprit([Suspicion(0, often, ratio)]) is None) == (ratio < 6.5)
        assert (culprit([Suspicion(0, seldom, ratio)]) is None) == (ratio < 7.6)


def test_without_data_nothing_is_said():
    assert log_ratio(np.zeros(3), np.eye(3), np.eye(3), [1], 100.0) == pytest.approx(0.0, abs=1e-6)


def test_a_drone_is_named_only_if_no_other_could_be_it():
    compass, gimbal, *_ = FAULTS
    surely = Suspicion(1, compass, 15.0)
    assert culprit([surely, Suspicion(0, compass, 8.0)]) is surely
    assert culprit([surely, Suspicion(0, compass, 12.0)]) is None
    assert culprit([surely, Suspicion(0, compass, 10.5)]) is None  # 98.9 %
    assert culprit([surely, Suspicion(1, gimbal, 14.0)]) is surely  # whatever is wrong with it
    assert culprit([Suspicion(1, compass, math.log(0.5 / TUNING.probability))]) is None
    assert culprit([]) is None


def test_drones_disagree_before_one_is_surely_wrong():
    compass, likely = FAULTS[0], math.log(5.0 / TUNING.probability)
    found = [Suspicion(0, compass, likely), Suspicion(1, compass, likely - 1.5)]
    assert suspects(found) == set()
    assert suspects(found, TUNING.probably) == {0, 1}
    assert suspects([Suspicion(0, compass, likely - 1.0)], TUNING.probably) == set()


@pytest.mark.parametrize(
    ("ratios", "expected"),
    [
        ([15.0, 15.0], {0, 1}),
        ([15.0, 12.0], {0, 1}),  # 4.7 % are not excluded
        ([15.0, 10.0], {0}),
        ([9.0, 15.0], {1}),
        ([15.0, 15.0, 9.0], {0, 1}),  # a right one is not drawn in
        ([7.0, 7.0], {0, 1}),  # 96 % together
        ([7.0], set()),  # 92 %
        ([], set()),
    ],
)
def test_drones_are_suspected_where_surely_one_is_wrong(ratios, expected):
    found = [Suspicion(drone, FAULTS[0], ratio) for drone, ratio in enumerate(ratios)]
    assert suspects(found) == expected


@pytest.mark.parametrize("drone", [0, 1])
def test_the_state_shows_whose_error_is_larger_than_stated(two_rtk, drone):
    fleet, _ = two_rtk.together()
    stationary = [one.stationary for one in fleet._drones]
    before = suspicions(fleet.table.state, stationary)
    assert culprit(before) is None
    assert len(before) == 2 * len(FAULTS)
    fleet.table.state.activate(drone)
    fleet.table.state.joint.mean[5] = math.radians(10.0)
    found = culprit(suspicions(fleet.table.state, stationary))
    assert (found.drone, found.fault.sensor) == (drone, "compass")
