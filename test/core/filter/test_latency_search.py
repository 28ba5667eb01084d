# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The latency found in flight, or left open: by its own sigma either is said."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.filter.latency_search import LatencySearch, _is_smooth
from aerial_gnss_ros.core.filter.pose_lattice import MARGIN, smoothed
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, quaternion_from_matrix
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.values.estimates import MapDatum, State
from aerial_gnss_ros.core.values.rejection import Input
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.feeding import feed
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import START_NS, sensor_plan

pytestmark = pytest.mark.flights

STATED = {"noise.gnss_offset_m": 0.02, "noise.robot_acceleration": 0.01}
ROBOTS = {"a": lambda _t: (2.0, 18.0), "b": lambda _t: (-3.0, 22.0), "c": lambda _t: (6.0, 24.0)}


def _late(sea, late_s, drone, rpy_deg):
    """A world whose images stamped t show t - late_s."""
    world = sea.World(drone=drone, rpy_deg=rpy_deg, robots=ROBOTS, pixel_sigma=2.0)
    seen = sea.World(
        drone=lambda t: drone(t - late_s), rpy_deg=lambda t: rpy_deg(t - late_s),
        robots=ROBOTS, pixel_sigma=2.0,
    )  # fmt: skip
    world.frame = seen.frame
    return world


def _reported(results):
    found = [one for result in results for one in result.platform if one.name == "latency"]
    return found[-1].value, found[-1].sigma


def _worst(results):
    """Return the largest error of a confirmed robot at the end, m, and in its own sigmas."""
    last = next(result for result in reversed(results) if result.pose is not None)
    places = np.array([place(0.0) for place in ROBOTS.values()])
    worst = sigmas = 0.0
    for one in last.estimates:
        if one.state is State.CONFIRMED:
            offsets = places - one.position
            error = offsets[np.argmin(np.linalg.norm(offsets, axis=1))]
            squared = error @ np.linalg.solve(one.covariance[:2, :2], error)
            worst = max(worst, float(np.linalg.norm(error)))
            sigmas = max(sigmas, math.sqrt(squared))
    return worst, sigmas


@pytest.mark.parametrize("late_s", [0.8, -0.6])
def test_a_camera_that_sways_a_little_tells_it(sea, late_s):
    """A hover: the gimbal wanders by 0.4 deg and back within 3 to 5 s, at 36 m a quarter metre."""
    drone = lambda _t: (0.0, 0.0, 30.0)  # noqa: E731
    rpy_deg = lambda t: (  # noqa: E731
        0.0, 60.0 + 0.4 * math.sin(1.3 * t), 90.0 + 0.6 * math.sin(2.1 * t + 1.0)
    )  # fmt: skip
    world = _late(sea, late_s, drone, rpy_deg)
    results = sea.play(sea.estimator(STATED | {"noise.latency_s": 0.8}), world, 12.0, telemetry=50)
    value, sigma = _reported(results)
    assert sigma < 0.06
    assert abs(value - late_s) < 4.0 * sigma
    assert abs(value - late_s) < 0.05
    assert _worst(results)[1] < 4.0


@pytest.mark.parametrize(("family", "late_s"), [("hover", 0.4), ("orbit", -0.4)])
def test_a_steady_flight_leaves_it_open(sea, family, late_s):
    """No sway at all: robots elsewhere look the same as a latency, and it stays as unknown."""
    rate = 0.15
    drone = lambda _t: (0.0, 0.0, 30.0)  # noqa: E731
    rpy_deg = lambda _t: (0.0, 60.0, 90.0)  # noqa: E731
    if family == "orbit":
        drone = lambda t: (28 * math.cos(rate * t), 20 + 28 * math.sin(rate * t), 30.0)  # noqa: E731
        rpy_deg = lambda t: (0.0, 47.0, math.degrees(rate * t) + 180.0)  # noqa: E731
    world = _late(sea, late_s, drone, rpy_deg)
    results = sea.play(sea.estimator(STATED | {"noise.latency_s": 0.3}), world, 12.0, telemetry=50)
    value, sigma = _reported(results)
    assert sigma > 0.15
    assert abs(value - late_s) < 4.0 * sigma
    assert _worst(results)[1] < 4.0
    assert len({one.robot_id for one in results[-1].estimates}) == len(ROBOTS)


@pytest.mark.parametrize(
    ("family", "late_s", "seed"),
    [("hover", 0.5, 1), ("hover", -1.0, 2), ("orbit", -0.5, 2), ("orbit", 2.5, 1)],
)
def test_simulated_flights_are_honest(family, late_s, seed):
    """Noise, slow errors and sway of a consumer drone; it is found within what it says."""
    plan = FlightPlan(kind=family, duration_s=12.0, height_m=30.0, speed_mps=5.0)
    made = Experiment(
        GeneratedFlight(plan, seed), default_camera(1280, 720),
        sensor_plan("consumer", gnss_offset_m=0.02), CameraClock(10.0, late_s),
        robots=3, swim=SwimPlan(0.0, 0.0, roam_m=1e3, apart_m=3.0), seed=seed,
    )  # fmt: skip
    engine = Estimator(
        estimator_config(
            STATED | {"noise.latency_s": abs(late_s), "fix.altitude_datum": "ellipsoid"}
        )
    )
    engine.add_camera(START_NS - 10**10, made.camera)
    feed(engine, made.sensors)
    for _, _, frame in made.detections():
        engine.add_detections(frame)
    value, sigma = _reported(engine.flush())
    assert abs(value - late_s) < 4.0 * sigma
    assert sigma < 0.15
    assert not [one for one in engine.events if "max_speed" in one]  # as it becomes known
    assert max(robot.sigma_m for robot in engine.robots) < 1.2


def test_images_that_have_been_compared_tell_nothing_twice(sea):
    engine = sea.estimator(STATED | {"noise.latency_s": 1.0})
    world = _late(sea, 0.5, lambda t: (5.0 * math.sin(t), 0.0, 30.0), lambda _t: (0.0, 60.0, 90.0))
    sea.play(engine, world, 10.0, images=5)
    former = engine._tracks.pipeline.latency
    scene, measured = engine._tracks.pipeline.measured
    old = replace(scene, detections=world.frame(5.0))
    for begin, again in (("follow", True), ("resume", False)):
        search = LatencySearch(engine._config, engine._inputs)
        getattr(search, begin)(former)
        assert search.found == former.found
        assert search.compare(old, measured, engine._origin.local) is again


def test_a_latency_is_known_no_better_than_stamps_of_telemetry(sea):
    found = []
    for stamps_s in (0.0, 0.2):
        engine = sea.estimator(STATED | {"noise.latency_s": 1.0})
        engine._tracks.pipeline.latency.stamp_sigma_s = stamps_s
        world = _late(
            sea, 0.5, lambda t: (5.0 * math.sin(t), 0.0, 30.0), lambda _t: (0.0, 60.0, 90.0)
        )
        found.append(_reported(sea.play(engine, world, 12.0, images=5)))
    assert found[1][0] == pytest.approx(found[0][0], abs=1e-3)
    assert found[1][1] == pytest.approx(math.hypot(found[0][1], 0.2), rel=0.01)


def test_it_is_not_estimated_unless_it_is_asked_for(sea):
    results = sea.play(sea.estimator(STATED), sea.World(robots=ROBOTS), 2.0)
    assert "latency" not in {one.name for result in results for one in result.platform}


@pytest.mark.parametrize(
    ("speed", "jump_m", "jump_deg", "smooth"),
    [
        (60.0, 0.0, 0.0, True),
        (0.0, 0.5, 5.0, True),
        (60.0, 2.0, 0.0, False),
        (0.0, 0.0, 20.0, False),
        (math.nan, 0.0, 0.0, False),
    ],
)
def test_telemetry_has_jumped_at_any_speed_of_the_drone(speed, jump_m, jump_deg, smooth):
    t = 0.1 * np.arange(30.0)
    late = t > 1.45
    positions = np.stack([speed * t + jump_m * late, np.zeros(30), np.full(30, 30.0)], axis=1)
    yaw = np.radians(jump_deg) * late
    rotations = np.array([matrix_from_rpy(0.0, 1.0, float(angle)) for angle in yaw])
    assert _is_smooth(smoothed(positions), smoothed(rotations)) is smooth
    assert len(smoothed(positions)) == 30 - 2 * MARGIN


@pytest.mark.parametrize(
    ("stated_s", "stamp_sigma_s", "found"),
    [
        # 0.9 at 0.25 +- 0.1443 s late and 0.1 anywhere, +- 1 s: the root of 0.9 times
        # 0.1443² + 0.025² and 0.1 times 1 + 0.225² is 0.353.
        (0.0, 0.5 / math.sqrt(12.0), (-0.225, 0.353)),
        (-1.0, 0.5 / math.sqrt(12.0), (0.0, 0.344)),  # what is stated contains the mean
        (0.0, 0.0, (0.0, 1.0)),
    ],
)
def test_telemetry_with_stamps_of_images_is_late_by_up_to_their_interval(
    stated_s, stamp_sigma_s, found
):
    config = estimator_config({"noise.latency_s": 1.0, "camera.latency_s": stated_s})
    search = LatencySearch(config, TelemetryBuffers(config))
    search.stamp_sigma_s = stamp_sigma_s
    search.conclude()
    assert search._posterior() == pytest.approx(found, abs=0.01)


@pytest.mark.parametrize(("deg", "metres", "jumps"), [(20.0, 0.0, 1), (0.0, 5.0, 0), (0.0, 0.0, 0)])
def test_a_gimbal_that_jumps_is_noted_and_a_receiver_that_does_is_taken_out(deg, metres, jumps):
    """Images about a jump of the gimbal tell nothing; the drone has not flown the receiver's."""
    config = estimator_config({"noise.latency_s": 1.0})
    inputs = TelemetryBuffers(config)
    for k in range(60):
        yaw = math.radians(deg) if k >= 30 else 0.0
        gimbal = quaternion_from_matrix(matrix_from_rpy(0.0, 1.0, yaw))
        east = metres / 6.2e6 if k >= 30 else 0.0
        inputs.add(Input.GIMBAL, Orientation(k * 10**8, gimbal))
        inputs.add(Input.FIX, Fix(k * 10**8, 0.2, 0.1 + east, 0.0))
        inputs.add(Input.HEIGHT, Scalar(k * 10**8, 20.0))
    search = LatencySearch(config, inputs)
    search._local = LocalMap(MapDatum(0.2, 0.1, 0.0))
    poses = [search._pose(k * 10**8 + 5 * 10**7) for k in range(5, 55)]
    found = search._lattice.jumps_s
    assert bool(found) == bool(jumps)
    assert all(abs(one - 2.95) < 0.15 for one in found)
    places = np.array([one.position for one in poses if not isinstance(one, bool)])
    assert len(places) == 50 - jumps  # none across a jump of the gimbal
    assert np.ptp(places, axis=0).max() < 0.02
