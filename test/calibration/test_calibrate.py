# SPDX-License-Identifier: Apache-2.0
"""Calibration of simulated flights whose errors are known."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.calibration.advice import advice, excitation
from aerial_gnss_ros.calibration.fit import UNKNOWNS, Fit, unknown
from aerial_gnss_ros.calibration.model import DRIFTING, LATENCY, Boxes, Layout, residuals
from aerial_gnss_ros.calibration.poses import PoseTable
from aerial_gnss_ros.calibration.problem import Problem
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.calibration.solve import calibrate
from aerial_gnss_ros.core.config import estimator_config
from aerial_gnss_ros.core.errors import InputError
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import SensorPlan, sensor_plan

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from calibration import record

DURATION_S = 40.0


def _experiment(
    kind: str, latency_s: float, seed: int, sensors: SensorPlan | None = None
) -> Experiment:
    flight = GeneratedFlight(FlightPlan(kind, DURATION_S, 20.0, speed_mps=3.0), seed)
    return Experiment(
        flight, default_camera(1280, 720), sensors or sensor_plan("consumer"),
        CameraClock(4.0, latency_s),
        robots=2, swim=SwimPlan(0.0, 0.0), seed=seed,
    )  # fmt: skip


def _record(experiment: Experiment, latency_s: float, noise: dict | None = None) -> Recording:
    """Drive a recording as a bag would, with `latency_s` configured."""
    values = {"camera": {"latency_s": latency_s}, "noise": noise or {}}
    return record(experiment, estimator_config(values))


def _truth(experiment: Experiment) -> dict[str, float]:
    """What has to be added to what was measured, in deg and m: the mean over the flight."""
    times = np.linspace(0.0, DURATION_S, 100)
    names = ("heading", "gimbal_pitch", "gimbal_roll", "height")
    return {name: -float(np.mean(experiment.sensors.error(name, times))) for name in names}


@pytest.mark.parametrize(
    ("kind", "latency_s", "configured_s", "seed"),
    [("transit", 2.5, 2.2, 1), ("transit", -1.5, 0.0, 2), ("orbit", 0.1, 0.0, 3)],
)
def test_latency_and_angles_are_recovered(kind, latency_s, configured_s, seed) -> None:
    experiment = _experiment(kind, latency_s, seed)
    recording = _record(experiment, configured_s)
    fit = calibrate(recording, estimator_config({"camera": {"latency_s": configured_s}}))
    # As the command does: with the latency nearly right, no box is taken for another robot's.
    configured_s += fit.value("latency")[0]
    recording = _record(experiment, configured_s)
    fit = calibrate(recording, estimator_config({"camera": {"latency_s": configured_s}}))
    value, sigma = fit.value("latency")
    assert configured_s + value == pytest.approx(latency_s, abs=0.05)
    assert fit.determined("latency")
    assert sigma < 0.05
    for name, true in _truth(experiment).items():
        value, sigma = fit.value(name)
        assert abs(value - true) < 3.5 * sigma, (name, value, true, sigma)
        assert sigma < 1.0  # not by knowing nothing


def test_noise_of_the_telemetry_does_not_shorten_the_focal_length() -> None:
    """Derivatives at the measured pose made it 7 to 11 % too short, 4 to 6 sigma, in each one."""
    noise = {"set": "rtk", "gnss_white_m": 0.2, "gimbal_white_deg": 0.15}
    plan = sensor_plan(noise["set"], gnss_white_m=0.2, gimbal_white_deg=0.15)
    config = estimator_config({"camera": {"latency_s": 0.1}, "noise": noise})
    off = []
    for seed in (1, 2, 3):
        recording = _record(_experiment("orbit", 0.1, seed, plan), 0.1, noise)
        problem = Problem(recording, config, tuple(one.name for one in UNKNOWNS), 0.0)
        value, sigma = problem.fit(problem.search(lambda _done: None), frozenset()).value("focal")
        assert sigma < 2.0  # not by knowing nothing
        off.append(value / sigma)
    assert abs(np.mean(off)) < 2.0


def test_a_hover_leaves_everything_but_the_latency_open() -> None:
    experiment = _experiment("hover", 0.0, 4)
    recording = _record(experiment, 0.0)
    fit = calibrate(recording, estimator_config({}))
    for name in ("heading", "gimbal_pitch", "gimbal_roll", "height"):
        assert not fit.determined(name)
        value, sigma = fit.value(name)
        assert abs(value) < 3.0 * unknown(name).enough * 2.0 or sigma > unknown(name).enough
    told = " ".join(advice(fit))
    assert "orbit a still robot once" in told
    assert excitation(recording).directions_deg <= 40.0
    assert "from 360 deg" not in " ".join(excitation(recording).words())


def test_too_little_to_go_by() -> None:
    recording = Recording(estimator_config({}))
    with pytest.raises(InputError, match="0 images"):
        calibrate(recording, estimator_config({}))


def test_all_determined_needs_no_advice() -> None:
    fit = Fit(("heading",), np.zeros(1), np.eye(1) * math.radians(0.1) ** 2, 2.0, 9, 0, 9, ("a",))
    assert advice(fit) == []
    assert fit.value("heading")[1] == pytest.approx(0.1)


def test_derivatives_of_the_boxes() -> None:
    """Against finite differences, a little off the measured pose."""
    recording = _record(_experiment("orbit", 0.0, 5), 0.0)
    sightings = recording.sightings[10:40:5]
    layout = Layout(sightings, still=True)
    table = PoseTable(recording)
    boxes = Boxes.of(sightings, layout)
    rng = np.random.default_rng(1)
    at = np.zeros(layout.size)
    for name in DRIFTING:
        at[layout.drift(name)] = rng.normal(0.0, 0.002, layout.knots)
    for robot in range(len(layout.robots)):
        at[layout.place(robot)] = sightings[0].places[robot]

    own = rng.normal(0.0, 0.002, (boxes.image_count, 6))

    def predicted(unknowns: np.ndarray, more: float = 0.0, column: int = 0) -> np.ndarray:
        shift = more * (np.arange(6) == column)
        return -residuals(table, boxes, layout, unknowns, own + shift, 0.0).values

    found = residuals(table, boxes, layout, at, own, 0.0)
    rates = np.abs(found.jacobian[:, :, LATENCY])
    for column in [c for c in range(layout.size) if c != LATENCY]:
        step = np.zeros(layout.size)
        step[column] = 1e-5
        numeric = (predicted(at + step) - predicted(at - step)) / 2e-5
        scale = 1.0 + np.abs(numeric).max()
        np.testing.assert_allclose(found.jacobian[:, :, column], numeric, atol=0.01 * scale)
    for column in range(6):
        numeric = (predicted(at, 1e-5, column) - predicted(at, -1e-5, column)) / 2e-5
        scale = 1.0 + np.abs(numeric).max()
        np.testing.assert_allclose(found.by_own[:, :, column], numeric, atol=0.01 * scale)
    # rates are means over 0.6 s, so this derivative is compared over as long
    step = np.zeros(layout.size)
    step[LATENCY] = 0.3
    numeric = (predicted(at + step) - predicted(at - step)) / 0.6
    np.testing.assert_allclose(
        found.jacobian[:, :, LATENCY], numeric, atol=0.3 * float(rates.max()) + 3.0
    )


def test_advice_names_each_flight_once() -> None:
    """Sigmas of 9 rad or m: nothing is determined; one orbit begins what four errors need."""
    names = ("heading", "gimbal_pitch", "gimbal_roll", "height")
    (told,) = advice(Fit(names, np.zeros(4), 81.0 * np.eye(4), 2.0, 9, 0, 9, ("a",)))
    assert told.startswith("for heading, gimbal pitch, gimbal roll and height: orbit a still robot")
    assert told.count("once more at") == 2  # twice the distance, half the height
