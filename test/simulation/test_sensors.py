# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sensors report the truth plus exactly the stated errors, at the stated rates."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion, rpy_from_matrix
from aerial_gnss_ros.core.geometry.gimbal import error_axes
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.sensors import START_NS, Sensors, sensor_plan, ticks

FLIGHT = GeneratedFlight(FlightPlan(kind="orbit"), seed=1)
METRES_PER_RADIAN = 6.335e6, 6.378e6 * math.cos(FLIGHT.origin.latitude)  # WGS84 at 13 deg, to 1 %


def matrices(stream):
    return matrix_from_quaternion(np.array([sample.quaternion for sample in stream]))


def small_angles(measured, true):
    """Rotation vectors of measured = exp(v) true, ENU."""
    turn = measured @ true.swapaxes(1, 2)
    return 0.5 * np.stack(
        [
            turn[:, 2, 1] - turn[:, 1, 2],
            turn[:, 0, 2] - turn[:, 2, 0],
            turn[:, 1, 0] - turn[:, 0, 1],
        ],
        axis=1,
    )


def test_ticks_are_whole_periods_round_the_start():
    at = ticks(50.0, -1.0, 2.0)
    assert len(at.t) == 151
    assert at.stamps_ns[0] == START_NS - 1_000_000_000
    assert START_NS in at.stamps_ns
    assert set(np.diff(ticks(30.0, 0.0, 100.0).stamps_ns)) == {33_333_333, 33_333_334}


def test_without_noise_the_sensors_tell_the_truth():
    sensors = Sensors(FLIGHT, sensor_plan("none"), 1, -1.0, 5.0)
    for measured, true in (
        (sensors.attitudes(), sensors.attitudes(true=True)),
        (sensors.gimbals(), sensors.gimbals(true=True)),
    ):
        np.testing.assert_allclose(matrices(measured), matrices(true), atol=1e-14)
    assert list(sensors.fixes()) == list(sensors.fixes(true=True))
    assert list(sensors.heights()) == list(sensors.heights(true=True))


def test_white_noise_has_the_stated_size():
    plan = sensor_plan(
        "none",
        gnss_white_m=0.5, attitude_white_deg=0.2, gimbal_white_deg=0.1, height_white_m=0.3,
    )  # fmt: skip
    sensors = Sensors(FLIGHT, plan, 2, 0.0, 200.0)
    difference = small_angles(matrices(sensors.attitudes()), matrices(sensors.attitudes(true=True)))
    np.testing.assert_allclose(np.degrees(difference).std(axis=0), 0.2, rtol=0.05)
    difference = small_angles(matrices(sensors.gimbals()), matrices(sensors.gimbals(true=True)))
    np.testing.assert_allclose(np.degrees(difference).std(axis=0), 0.1, rtol=0.05)
    pairs = list(zip(sensors.fixes(), sensors.fixes(true=True), strict=True))
    for name, metres in zip(("latitude", "longitude"), METRES_PER_RADIAN, strict=True):
        errors = np.array([getattr(a, name) - getattr(b, name) for a, b in pairs]) * metres
        assert errors.std() == pytest.approx(0.5, rel=0.05)
        assert abs(np.corrcoef(errors[:-1], errors[1:])[0, 1]) < 0.1
    heights = zip(sensors.heights(), sensors.heights(true=True), strict=True)
    assert np.std([a.value - b.value for a, b in heights]) == pytest.approx(0.3, rel=0.05)


def test_slow_errors_have_the_stated_size_over_many_flights():
    names = {
        "gnss_east": 1.2, "gnss_north": 1.2, "gnss_up": 1.8, "heading": 1.5,
        "gimbal_pitch": 0.4, "gimbal_roll": 0.4, "height": 0.3,
    }  # fmt: skip
    plan = sensor_plan("consumer")
    draws = {name: [] for name in names}
    for seed in range(600):
        sensors = Sensors(FLIGHT, plan, seed, 0.0, 0.2)
        for name in names:
            draws[name].append(sensors.error(name, np.array([0.1]))[0])
    for name, sigma in names.items():
        assert np.std(draws[name]) == pytest.approx(sigma, rel=0.1), name
        assert abs(np.mean(draws[name])) < 0.2 * sigma, name
    both = np.corrcoef(draws["gnss_east"], draws["heading"])[0, 1]
    assert abs(both) < 0.15


def test_body_and_camera_share_the_compass_and_the_camera_errs_about_its_level_axes():
    plan = sensor_plan("none", heading_deg=2.0, gimbal_pitch_deg=1.0, gimbal_roll_deg=1.0)
    sensors = Sensors(FLIGHT, plan, 3, 0.0, 10.0)
    t = ticks(50.0, 0.0, 10.0).t
    body = small_angles(matrices(sensors.attitudes()), matrices(sensors.attitudes(true=True)))
    heading = np.radians(sensors.error("heading", t))
    np.testing.assert_allclose(body[:, 2], np.sin(heading), atol=1e-9)
    np.testing.assert_allclose(body[:, :2], 0.0, atol=1e-12)
    true = matrices(sensors.gimbals(true=True))
    camera = small_angles(matrices(sensors.gimbals()), true)
    expected = np.radians(
        np.column_stack(
            [sensors.error(name, t) for name in ("gimbal_roll", "gimbal_pitch", "heading")]
        )
    )
    turned = np.array([error_axes(m) @ e for m, e in zip(true, expected, strict=True)])
    np.testing.assert_allclose(camera, turned, atol=2e-3)  # second order of 2 deg
    # Counter-clockwise heading error: measured yaw is larger than the true one.
    yaw = rpy_from_matrix(matrices(sensors.attitudes()))[:, 2]
    true_yaw = rpy_from_matrix(matrices(sensors.attitudes(true=True)))[:, 2]
    np.testing.assert_allclose((yaw - true_yaw + np.pi) % (2 * np.pi) - np.pi, heading, atol=1e-9)


def test_a_fix_states_its_covariance_only_when_asked():
    quiet = next(iter(Sensors(FLIGHT, sensor_plan("rtk"), 1, 0.0, 1.0).fixes()))
    assert quiet.covariance is None
    plan = sensor_plan("none", gnss_offset_m=0.3, gnss_white_m=0.4)
    stating = Sensors(FLIGHT, type(plan)(plan.noise, plan.sigmas, covariance=True), 1, 0.0, 1.0)
    fix = next(iter(stating.fixes()))
    np.testing.assert_allclose(np.diag(fix.covariance), [0.25, 0.25, 0.5625])
    assert next(iter(stating.fixes(true=True))).covariance is None
