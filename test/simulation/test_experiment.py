# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A simulated flight is consistent: its truth, put through the core, gives its truth."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic
from aerial_gnss_ros.core.georeferencing.localization import locate
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.errors import ConfigError, InputError
from aerial_gnss_ros.core.values.rejection import Input
from aerial_gnss_ros.simulation.experiment import (
    CameraClock,
    Experiment,
    default_camera,
)
from aerial_gnss_ros.simulation.feeding import feed
from aerial_gnss_ros.simulation.flight import KINDS, FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.placement import place_robots
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import START_NS, sensor_plan

AFLOAT = SwimPlan(heave_m=0.0)


def experiment(kind="orbit", duration=6.0, latency=0.0, seed=1, **plan):
    return Experiment(
        GeneratedFlight(FlightPlan(kind=kind, duration_s=duration, **plan), seed),
        default_camera(1280, 720),
        sensor_plan("none"),
        CameraClock(latency_s=latency),
        swim=AFLOAT,
        seed=seed,
    )


def east_north(made, latitude, longitude):
    o = made.flight.origin
    enu = enu_from_geodetic(latitude, longitude, o.altitude, o.latitude, o.longitude, o.altitude)
    return enu[..., :2]


@pytest.mark.parametrize("kind", KINDS)
def test_true_boxes_and_poses_give_true_positions(kind):
    made = experiment(kind, duration=20.0, camera_offset_m=(0.1, 0.0, -0.1))
    count = 0
    for frame, boxes, _ in made.detections():
        points = locate(made.true_pose(frame), made.camera, boxes.centers, Noise())
        index = [made.swarm.names.index(name) for name in boxes.names]
        truth = made.swarm.positions([frame.t])[index, 0, :2]
        got = east_north(made, points.latitude, points.longitude)
        np.testing.assert_allclose(got, truth, atol=1e-3)
        count += len(index)
    assert count > 400


@pytest.mark.parametrize("latency", [0.0, 0.4, -1.3])
@pytest.mark.parametrize("kind", KINDS)
def test_noise_free_telemetry_through_the_estimator_gives_the_truth(kind, latency):
    """Stamps, interpolation, both signs of latency, lever arm: all of it, to 2 cm."""
    made = experiment(kind, latency=latency, camera_offset_m=(0.1, 0.05, -0.1))
    offset = {"offset_m": [0.1, 0.05, -0.1], "latency_s": latency}
    estimator = Estimator(
        estimator_config({"method": "single", "camera": offset, "tracks": {"confirm_hits": 1}})
    )
    feed(estimator, made.sensors, tuple(Input))
    estimator.add_camera(START_NS, made.camera)
    scenes = {}
    for frame, boxes, _ in made.detections():
        count = len(boxes.names)
        estimator.add_detections(
            DetectionFrame(
                frame.stamp_ns, "camera", boxes.centers, boxes.sizes, np.ones(count),
                boxes.class_names,
            )
        )  # fmt: skip
        scenes[frame.stamp_ns] = frame.t
    results = estimator.flush()
    assert len(results) == len(scenes) == 60
    worst, count = 0.0, 0
    for result in results:
        truth = made.swarm.positions([scenes[result.stamp_ns]])[:, 0, :2]
        assert not result.rejections
        for estimate in result.estimates:
            if estimate.last_seen_ns == result.stamp_ns:
                got = east_north(made, estimate.latitude, estimate.longitude)
                worst = max(worst, np.linalg.norm(truth - got, axis=1).min())
                count += 1
    assert count > 100
    assert worst < 0.02


def test_an_image_shows_the_scene_one_latency_before_its_stamp():
    for latency, log_after in ((0.5, 0.08), (-0.5, 0.58)):
        made = experiment(latency=latency)
        frames = made.frames()
        assert len(frames) == 60
        assert frames[0].stamp_ns == START_NS
        assert frames[10].t == pytest.approx(1.0 - latency)
        pose = made.flight.sample([1.0 - latency])
        np.testing.assert_array_equal(frames[10].pose.position, pose.camera[0])
        assert (frames[10].log_ns - frames[10].stamp_ns) * 1e-9 == pytest.approx(log_after)


def test_telemetry_and_truth_bracket_every_scene():
    made = experiment(latency=-1.3)
    scenes = [frame.t for frame in made.frames()]
    streams = [made.sensors.fixes(), made.sensors.gimbals(), made.sensors.heights()]
    streams += [iter(path) for _, path in made.robot_fixes()]
    for stream in streams:
        stamps = np.array([sample.stamp_ns - START_NS for sample in stream]) * 1e-9
        assert stamps[0] < scenes[0]
        assert stamps[-1] > scenes[-1]


def test_robots_are_placed_where_they_are_seen_and_apart():
    flight = GeneratedFlight(FlightPlan(kind="orbit", duration_s=30.0), seed=5)
    camera = default_camera(1280, 720)
    places = place_robots(flight, camera, 8, np.random.default_rng(5))
    gaps = np.linalg.norm(places[:, None] - places[None], axis=2)[np.triu_indices(8, 1)]
    assert gaps.min() > 1.2
    still = SwimPlan(slowest_mps=0.0, fastest_mps=0.0)
    made = Experiment(flight, camera, places=places, swim=still, seed=5)
    seen = [len(made.projected(frame).names) for frame in made.frames()]
    assert np.mean(seen) > 7.0


@pytest.mark.parametrize("kind", KINDS)
def test_a_camera_that_looks_straight_down_flies_over_the_first_robot(kind):
    made = experiment(kind, duration=30.0, tilt=math.radians(90.0), speed_mps=2.0)
    over = made.flight.sample(np.linspace(0.0, 30.0, 300)).antenna[:, :2]
    assert np.linalg.norm(over - made.places[0], axis=1).min() < 0.5
    assert np.linalg.norm(made.places[1:] - made.places[0], axis=1).min() > 0.9


@pytest.mark.parametrize("height", [5.0, 30.0, 80.0])
@pytest.mark.parametrize("kind", KINDS)
def test_robots_are_in_view_from_any_height(kind, height):
    made = experiment(kind, duration=30.0, height_m=height, seed=2)
    seen = [len(made.projected(frame).names) for frame in made.frames()]
    assert np.mean(seen) > 2.4


def test_a_camera_that_sees_only_sky_cannot_be_given_robots():
    class Upwards:
        origin = GeneratedFlight(FlightPlan(), 1).origin
        duration_s = 5.0
        words = "a flight that looks up"

        def sample(self, t):
            motion = GeneratedFlight(FlightPlan(), 1).sample(t)
            motion.enu_from_camera[:] = np.eye(3)
            motion.enu_from_camera[:, :, 0] = [0.0, 0.0, 1.0]
            motion.enu_from_camera[:, :, 2] = [-1.0, 0.0, 0.0]
            return motion

    with pytest.raises(InputError, match="sees no water"):
        place_robots(Upwards(), default_camera(640, 360), 2, np.random.default_rng(1))


@pytest.mark.parametrize("wrong", [{"rate_hz": 0.0}, {"latency_s": 3.5}, {"latency_s": math.nan}])
def test_an_impossible_camera_clock_is_refused(wrong):
    with pytest.raises(ConfigError, match="must lie within"):
        CameraClock(**wrong)
