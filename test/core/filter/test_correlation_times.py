# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Slow errors that change within half a minute are found to do so; others are left alone."""

from __future__ import annotations

import copy
import functools
import math

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.filter.correlation_times import TUNING, CorrelationTimes
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.models.motion_model import motion_model
from aerial_gnss_ros.core.models.platform_model import COUNT, PlatformModel

pytestmark = pytest.mark.flights

PLACES = {"a": (2.0, 32.0), "b": (-6.0, 27.0), "c": (7.0, 25.0)}
SIGMA_DEG = np.array([0.4, 0.4, 1.5])
STEP_S = 0.05


def wandering(lasts_s, sigmas, seed, seconds=40.0):
    """Return roll, pitch and heading (n, 3) that nobody measures, deg, at each step."""
    rng = np.random.default_rng(seed)
    keep = math.exp(-STEP_S / lasts_s)
    found = [sigmas * rng.standard_normal(3)]
    for _ in range(round(seconds / STEP_S) + 1):
        fresh = math.sqrt(1.0 - keep * keep) * sigmas * rng.standard_normal(3)
        found.append(keep * found[-1] + fresh)
    return np.array(found)


def flown(sea, lasts_s, seed, larger=1.0, stated=None):
    """Return the joint filter after a hover, and the mean error by covariance of its last half."""
    errors = wandering(lasts_s, larger * SIGMA_DEG, seed)
    world = sea.World(
        robots={name: (lambda _, at=at: at) for name, at in PLACES.items()},
        drone=lambda _: (0.0, 0.0, 30.0), rpy_deg=lambda _: (0.0, 50.0, 90.0), pixel_sigma=2.0,
    )  # fmt: skip
    gimbal = world.gimbal

    def wrong(t):
        world.rpy_bias_deg = errors[round(t / STEP_S)]
        return gimbal(t)

    world.gimbal = wrong
    settings = {"noise.gnss_offset_m": 0.02, "tracks.find_moored": False} | (stated or {})
    engine = sea.estimator(settings)
    results = sea.play(engine, world, 40.0, images=5)
    sizes = [
        0.5 * min(
            float(off @ np.linalg.solve(one.covariance[:2, :2], off))
            for off in (one.position - at for at in PLACES.values())
        )
        for result in results[100:]
        for one in result.estimates
    ]  # fmt: skip
    return engine._tracks.pipeline.tracking.table.filter, np.mean(sizes)


@pytest.fixture(scope="module")
def quick(sea):
    """Return a function that returns a flight whose errors change quickly, by seed; flown once."""
    return functools.cache(lambda seed: flown(sea, TUNING.quick_s, seed, 2.0))


@pytest.mark.parametrize("seed", [1, 2])
def test_errors_that_change_within_half_a_minute_are_found_to_do_so(quick, seed):
    joint, size = quick(seed)
    assert joint.model.correlation_time_s == TUNING.quick_s
    assert size < 2.0**2 * 1.5  # they are twice as large as stated
    assert any("noise.correlation_time_s" in one for one in joint.monitor.complaints)


@pytest.mark.parametrize("seed", [1, 2])
def test_errors_that_last_for_minutes_are_left_alone(sea, seed):
    joint, size = flown(sea, 300.0, seed)
    assert joint.model.correlation_time_s == 300.0
    assert not any("noise.correlation_time_s" in one for one in joint.monitor.complaints)
    assert size < 3.0


def test_a_short_time_that_is_stated_is_the_only_one(sea):
    joint, _ = flown(sea, TUNING.quick_s, 1, 2.0, {"noise.correlation_time_s": 20.0})
    assert joint.model.correlation_time_s == 20.0


def test_it_begins_anew_with_the_filter(quick):
    joint = copy.deepcopy(quick(1)[0])
    joint.reset()
    assert joint.model.correlation_time_s == 300.0
    assert joint.laws.times.evidence < 0.0


def test_a_robot_that_is_found_again_is_so_in_both_states():
    """Where the receiver's error is uncertain by 4 m² in one state, and by 1 m² in the other."""
    config = estimator_config({})
    times = CorrelationTimes(PlatformModel(config.noise, config.gimbal.reference))
    base = JointState(np.eye(COUNT))
    own = np.tile(np.eye(4), (2, 1, 1))
    by_platform = np.zeros((2, 4, COUNT))
    by_platform[1, 0, 0] = 1.0
    places = np.array([[0.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0]])
    base.append(np.arange(2), places, by_platform, own)
    times.join(base, 0, 1, 0.1, 5.0)  # no state runs yet
    times.predict(base, 0.0, np.eye(COUNT), motion_model(config))
    times._base, times._law = base, JointState(4.0 * np.eye(COUNT))
    times._law.append(np.arange(2), places, by_platform, own)
    times._law.ids = base.ids
    times.join(base, 0, 1, 0.1, 5.0)
    squared, size = 4.0 / 6.01, math.log(6.01) + math.log(2.01)
    assert times._told_nats == pytest.approx(-0.5 * (squared + size) - 5.0)
    assert times._law.mean[0] == pytest.approx(-2.0 * 4.0 / 6.01)
    times.join(JointState(np.eye(COUNT)), 0, 1, 0.1, 5.0)  # another group
    assert times._law.mean[0] == pytest.approx(-2.0 * 4.0 / 6.01)
