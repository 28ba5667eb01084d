# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Smooth poses: motion is kept, errors of telemetry are not taken for motion."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.calibration.motion import Motion, adapted, error_axes_of
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.gimbal import error_axes
from aerial_gnss_ros.simulation.sensors import START_NS

sys.path.insert(0, str(Path(__file__).parent))

from flights import experiment, record


def test_what_is_motion_and_what_is_error() -> None:
    """A swing of 4 s and 1 m, samples of 0.1 s: its bends exceed 0.01 m of noise from 0.2 s on:
    (0.5 pi 0.2)^4 / 2 is 0.005 m^2, over 0.1 s a sixteenth of that, and the noise's 0.0006."""
    t = 0.1 * np.arange(600)
    swing = np.sin(0.5 * np.pi * t)
    rng = np.random.default_rng(1)
    noisy = swing + 0.3 * rng.normal(size=len(t))
    drifting = np.cumsum(0.3 * np.sqrt(0.1) * rng.normal(size=len(t)))
    table = np.stack([swing, noisy, drifting], axis=1)
    spline, (clear, longer, never) = adapted(t, table, [(0.0, 0.01), (0.0, 0.3), (0.09, 0.0)])
    assert clear == pytest.approx(0.2)
    assert 0.4 <= longer < 1.7
    assert never > 3.0  # nothing but the drift that is stated
    off = spline(t)[50:-50] - swing[50:-50, None]
    assert np.std(off[:, 0]) < 0.01
    assert np.std(off[:, 1]) < 0.25  # 0.3 of noise, and a part of the swing
    assert np.std(np.diff(off[:, 1])) < 0.05  # what a fit would take for motion; 0.42 before


def test_poses_are_near_the_true_ones_and_rates_too() -> None:
    made = experiment("orbit", 0.0, 5, noise="rtk", telemetry_hz=50.0)
    motion = Motion(record(made, estimator_config({"noise": {"set": "rtk"}})))
    t = np.linspace(2.0, 28.0, 200)
    stamps = (START_NS + t * 1e9).astype(np.int64)
    poses, true = motion.at(stamps, 0.0, 0.0), made.flight.sample(t)
    off = poses.position - true.camera
    assert np.std(off - off.mean(axis=0)) < 0.03
    early, late = made.flight.sample(t - 0.05), made.flight.sample(t + 0.05)
    assert np.std(poses.velocity - (late.camera - early.camera) / 0.1) < 0.1
    turned = late.enu_from_camera @ early.enu_from_camera.swapaxes(1, 2)
    rate = (turned[:, 1, 0] - turned[:, 0, 1]) / 0.2
    assert np.corrcoef(poses.turning[:, 2], rate)[0, 1] > 0.98
    assert abs(np.mean(poses.turning[:, 2] / rate) - 1.0) < 0.05


def test_delays() -> None:
    """A latency takes all of the pose earlier, an extra delay its place alone later."""
    made = experiment("transit", 0.0, 5)
    motion = Motion(record(made))
    stamps = (START_NS + np.array([10.0, 15.0]) * 1e9).astype(np.int64)
    early, now = motion.at(stamps, 0.5, 0.0), motion.at(stamps, 0.0, 0.0)
    both = motion.at(stamps - 500_000_000, 0.0, 0.0)
    np.testing.assert_allclose(early.position, both.position)
    np.testing.assert_allclose(early.rotation, both.rotation)
    apart = motion.at(stamps, 0.5, 0.5)
    np.testing.assert_allclose(apart.position, now.position)
    np.testing.assert_allclose(apart.rotation, early.rotation)
    assert not motion.at(stamps + 10**11, 0.0, 0.0).known.any()


def test_lever_arm_and_gaps() -> None:
    config = estimator_config({"camera": {"offset_m": [0.0, 0.0, -2.0]}})
    made = experiment("hover", 0.0, 5)
    recording = record(made, config)
    for attitude in made.sensors.attitudes():
        recording.add_attitude(attitude)
    stamps = (START_NS + np.array([10.0]) * 1e9).astype(np.int64)
    plain = Motion(record(made)).at(stamps, 0.0, 0.0).position
    lever = Motion(recording).at(stamps, 0.0, 0.0).position
    assert abs((lever - plain)[0, 2] + 2.0) < 0.1
    recording.stamps = {
        source: [s for s in values if not 9e9 < s - START_NS < 14e9]
        for source, values in recording.stamps.items()
    }
    assert not Motion(recording).at(stamps, 0.0, 0.0).known.any()


def test_axes_of_many_cameras() -> None:
    turns = np.array([matrix_from_rpy(0.1, 0.7, 2.0), matrix_from_rpy(0.0, np.pi / 2, 0.3)])
    expected = [error_axes(one) for one in turns]
    np.testing.assert_allclose(error_axes_of(turns), expected)
