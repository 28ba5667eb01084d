# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Calibration of simulated flights whose errors are known."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.calibration.solve import calibrate
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.values.errors import InputError

sys.path.insert(0, str(Path(__file__).parent))

from flights import experiment, record

CONFIG = estimator_config({})


def _truth(made, name: str) -> float:
    times = np.linspace(0.0, made.flight.duration_s, 100)
    return -float(np.mean(made.sensors.error(name, times)))


@pytest.mark.parametrize(("latency_s", "configured_s"), [(2.5, 0.0), (-1.5, 1.0)])
def test_still_robots_tell_everything_from_far_off(latency_s, configured_s) -> None:
    """Nothing is known of the latency before, and what is configured is not believed."""
    config = estimator_config({"camera": {"latency_s": configured_s}})
    made = experiment("transit", latency_s, 2)
    fit = calibrate(record(made, config), config)
    value, sigma = fit.value("latency")
    assert fit.determined("latency")
    assert configured_s + value == pytest.approx(latency_s, abs=min(0.05, 3.5 * sigma))
    for name in ("heading", "gimbal_pitch", "gimbal_roll", "height"):
        value, sigma = fit.value(name)
        assert fit.determined(name)
        assert abs(value - _truth(made, name)) < 3.5 * sigma, name
    assert max(fit.speeds_mps) < 0.02
    assert "aqua 1 stayed, aqua 2 stayed" in fit.moved()


def test_swimming_robots_tell_the_latency_and_nothing_else() -> None:
    """README's own kind of flight gave a latency 1.5 s and a height 14 m off as determined."""
    made = experiment("orbit", 0.0, 1, swims=True, images_hz=4.0)
    fit = calibrate(record(made), CONFIG)
    value, sigma = fit.value("latency")
    assert abs(value) < 3.5 * sigma
    assert min(fit.speeds_mps) > 0.1
    assert "swam at" in fit.moved()
    for name in ("heading", "gimbal_pitch", "gimbal_roll", "height"):
        assert not fit.determined(name)


def test_fixes_that_are_later_than_orientations() -> None:
    """0.3 s at 3 m/s is 0.9 m: images are in time with the gimbal, fixes are not."""
    made = experiment("transit", 0.0, 4, images_hz=4.0)
    fit = calibrate(record(made, fixes_late_s=0.3), CONFIG)
    for name, true in (("latency", 0.0), ("fix_latency", 0.3)):
        value, sigma = fit.value(name)
        assert value == pytest.approx(true, abs=min(0.06, 3.5 * sigma)), name


def test_telemetry_once_a_second() -> None:
    """What the gimbal did between samples is an error of the poses, not of the boxes."""
    config = estimator_config({"gimbal": {"max_gap": 2.5}})
    made = experiment("orbit", -1.2, 3, images_hz=5.0, telemetry_hz=1.0, duration_s=60.0)
    fit = calibrate(record(made, config), config)
    value, sigma = fit.value("latency")
    assert abs(value + 1.2) < 3.0 * sigma
    assert fit.residual_px == pytest.approx(2.0, abs=0.15)


def test_samples_that_are_sent_again_are_no_measurements() -> None:
    """Each value stands twice, as in logs written with the images: the second one says nothing."""
    gaps = {name: {"max_gap": 3.0} for name in ("gimbal", "height", "fix")}
    config = estimator_config(gaps)
    made = experiment("transit", 0.1, 2, swims=True, telemetry_hz=2.0)
    fit = calibrate(record(made, config, repeats=2), config)
    value, sigma = fit.value("latency")
    assert abs(value - 0.1) < 3.0 * sigma
    assert sigma < 0.06
    assert fit.ambiguities == {}


def test_telemetry_of_another_flight_determines_nothing() -> None:
    made, other = (experiment("orbit", 0.0, seed, images_hz=1.0) for seed in (1, 9))
    fit = calibrate(record(other, boxes_of=made), CONFIG)
    assert not any(fit.determined(name) for name in fit.names)


def test_robots_faster_than_robots_can_be_do_not_fit() -> None:
    config = estimator_config({"tracks": {"max_speed": 0.15}})
    made = experiment("transit", 0.0, 3, swims=True)
    fit = calibrate(record(made, config), config)
    assert "faster than they can: aqua" in " ".join(fit.misfit)
    assert not any(fit.determined(name) for name in fit.names)


def test_too_little_to_go_by() -> None:
    made = experiment("hover", 0.0, 1, duration_s=9.0)
    with pytest.raises(InputError, match="18 images have boxes"):
        calibrate(record(made), CONFIG)
    far = experiment("hover", 0.0, 1, duration_s=12.0)
    for frame in far.frames():
        assert frame.t < 20.0
    recording = record(far)
    recording.frames = {stamp + 10**11: frame for stamp, frame in recording.frames.items()}
    with pytest.raises(InputError, match="telemetry around them"):
        calibrate(recording, CONFIG)
