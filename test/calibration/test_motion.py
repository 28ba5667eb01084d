# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Smooth poses: motion is kept, errors of telemetry are not taken for motion."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.calibration.motion import Motion
from aerial_gnss_ros.calibration.pose_errors import error_axes_of
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.simulation.sensors import START_NS

sys.path.insert(0, str(Path(__file__).parent))

from flights import experiment, record


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


def test_errors_between_samples_are_as_large_as_said() -> None:
    """Samples a second apart: the gimbal's sway between them, against the true poses."""
    made = experiment("transit", 0.0, 5, telemetry_hz=1.0, duration_s=60.0)
    motion = Motion(record(made, estimator_config({"gimbal": {"max_gap": 2.5}})))
    t = np.linspace(3.0, 57.0, 500)
    stamps = (START_NS + t * 1e9).astype(np.int64)
    true = made.flight.sample(t).enu_from_camera
    turned = Rotation.from_matrix(motion.at(stamps, 0.0, 0.0).rotation @ true.swapaxes(1, 2))
    off = np.einsum("nji,nj->ni", error_axes_of(true), turned.as_rotvec())
    slow = [made.sensors.error(name, t) for name in ("gimbal_roll", "gimbal_pitch", "heading")]
    off -= np.radians(np.column_stack(slow))
    sigma = motion.interpolation(stamps, 0.0, np.full(len(t), 30.0))
    assert 0.4 < np.sqrt(np.mean(np.square(off / sigma))) < 1.6
    often = Motion(record(experiment("transit", 0.0, 5, telemetry_hz=10.0, duration_s=60.0)))
    seldom = float(np.sqrt(np.mean(sigma**2)))
    assert seldom > 3.0 * np.sqrt(np.mean(often.interpolation(stamps, 0.0, 1e3 + 0.0 * t) ** 2))
    near = motion.interpolation(stamps, 0.0, np.full(len(t), 3.0))
    assert np.all(near >= sigma)
    assert np.mean(near) > 2.0 * np.mean(sigma)  # the place's error is a larger angle there
