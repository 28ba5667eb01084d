# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The bound of a latency holds what telemetry lacks between its samples, and what robots do."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from calibration_bound import ExactMotion, bound

from aerial_gnss_ros.calibration.pose_errors import error_axes_of
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.feeding import feed
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import START_NS, sensor_plan

CONFIG = estimator_config({"gimbal": {"max_gap": 2.5}, "height": {"max_gap": 2.5}})


def _flown(telemetry_hz: float = 10.0, speed_mps: float = 0.0) -> Experiment:
    flight = GeneratedFlight(FlightPlan("transit", 40.0, 20.0, speed_mps=3.0), 7)
    plan = replace(
        sensor_plan(), gimbal_hz=telemetry_hz, fix_hz=telemetry_hz, height_hz=telemetry_hz
    )
    return Experiment(
        flight, default_camera(1280, 720), plan, CameraClock(4.0, 0.6), robots=2,
        swim=SwimPlan(speed_mps, speed_mps), seed=7,
    )  # fmt: skip


def _bound(made: Experiment, **noise: object) -> float:
    recording = Recording(replace(CONFIG, noise=replace(CONFIG.noise, **noise)))
    recording.add_camera(made.frames()[0].stamp_ns, made.camera)
    feed(recording, made.sensors)
    for _, _, boxes in made.detections():
        recording.add_detections(boxes)
    return bound(made, recording, 100)


def test_what_makes_a_latency_harder_to_find_raises_the_bound() -> None:
    often = _bound(_flown())
    assert 0.002 < often < 0.02
    exact = {"gimbal_white_deg": 1e-3, "gnss_white_m": 1e-3, "box_center_px": 0.3, "set": "rtk"}
    assert _bound(_flown(1.0), **exact) > 1.25 * _bound(_flown(10.0), **exact)
    assert _bound(_flown(speed_mps=0.4)) > 1.3 * often
    assert (
        1.1 * often < _bound(_flown(), box_center_px=4.0) < 2.0 * often
    )  # drifts do not grow with boxes


def test_errors_of_poses_are_those_of_the_poses() -> None:
    """Samples a second apart, without noise: error and sigma, each over the whole flight."""
    made = _flown(1.0)
    motion = ExactMotion(made, CONFIG)
    t = np.linspace(2.0, 38.0, 400)
    stamps = (START_NS + t * 1e9).astype(np.int64)
    poses, true = motion.at(stamps, 0.0, 0.0), made.flight.sample(t)
    turned = Rotation.from_matrix(poses.rotation @ true.enu_from_camera.swapaxes(1, 2))
    off = np.einsum("nji,nj->ni", error_axes_of(true.enu_from_camera), turned.as_rotvec())
    sigma = motion.interpolation(stamps, 0.0, np.full(len(t), 1e9))
    assert np.sqrt(np.mean(off**2)) == pytest.approx(np.sqrt(np.mean(sigma**2)), rel=0.15)
    np.testing.assert_allclose(poses.position[:, :2] + motion.origin, true.camera[:, :2], atol=0.4)
