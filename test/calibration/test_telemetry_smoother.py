# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Motion beyond the stated errors stays; what errors can explain is smoothed away."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.calibration.telemetry_smoother import TelemetrySmoother
from aerial_gnss_ros.core.config.noise import Noise

T = np.arange(0.0, 20.0, 0.1)


def smoother(**noise):
    return TelemetrySmoother(Noise(**noise), "earth")


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def test_a_steady_flight_is_smoothed_to_a_part_of_its_noise():
    rng = np.random.default_rng(1)
    way = np.column_stack([2.0 * T, 5.0 - T])
    noisy = way + 0.3 * rng.standard_normal(way.shape)
    found = smoother(gnss_white_m=0.3, gnss_offset_m=0.0).level(T, noisy)(T)
    assert rms(found - way) < 0.5 * rms(noisy - way)


def test_motion_larger_than_the_noise_stays():
    height = (20.0 + 3.0 * np.sin(1.5 * T))[:, None]
    found = smoother(height_white_m=0.05, height_m=0.0).height(T, height)(T)
    assert rms(found - height) < 0.05


def test_orientations_are_smoothed_whatever_the_signs_of_their_quaternions():
    rng = np.random.default_rng(2)
    true = Rotation.from_euler("ZYX", np.column_stack([0.2 * T, 0.9 + 0.05 * np.sin(T), 0.0 * T]))
    noise = 0.01 * rng.standard_normal((len(T), 3))
    quaternions = (Rotation.from_rotvec(noise) * true).as_quat()
    flipped = quaternions * rng.choice([-1.0, 1.0], len(T))[:, None]

    def smoothed(values):
        found = Rotation.from_quat(
            smoother(gimbal_pitch_deg=0.01, heading_deg=0.01).turn(T, values)(T)
        )
        return found, rms((found * true.inv()).as_rotvec())

    (one, error), (other, _) = smoothed(quaternions), smoothed(flipped)
    assert error < rms(noise)
    assert rms((one * other.inv()).as_rotvec()) == pytest.approx(0.0, abs=1e-9)


def test_the_longest_smoothing_time_of_each_input_is_kept():
    one = smoother(height_white_m=0.3)
    rng = np.random.default_rng(3)
    one.height(T, (20.0 + 0.3 * rng.standard_normal(len(T)))[:, None])
    (long,) = one.times_s["height"]
    one.height(T, (20.0 + 3.0 * np.sin(2.0 * T))[:, None])
    assert one.times_s["height"] == [long]
