# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Short simulated flights for tests of the calibration."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.values.rejection import Input
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.feeding import deliver, telemetry
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import sensor_plan


def experiment(
    kind: str, latency_s: float, seed: int, *, swims: bool = False, images_hz: float = 2.0,
    noise: str = "consumer", duration_s: float = 30.0, telemetry_hz: float = 10.0,
) -> Experiment:  # fmt: skip
    """Return a flight at 20 m over two robots."""
    flight = GeneratedFlight(FlightPlan(kind, duration_s, 20.0, speed_mps=3.0), seed)
    plan = sensor_plan(noise)
    plan = replace(
        plan, gimbal_hz=telemetry_hz, attitude_hz=telemetry_hz,
        fix_hz=min(plan.fix_hz, telemetry_hz), height_hz=min(plan.height_hz, telemetry_hz),
    )  # fmt: skip
    speeds = (0.2, 0.5) if swims else (0.0, 0.0)
    return Experiment(
        flight, default_camera(1280, 720), plan, CameraClock(images_hz, latency_s),
        robots=2, swim=SwimPlan(*speeds), seed=seed,
    )  # fmt: skip


def record(
    made: Experiment,
    config: EstimatorConfig | None = None,
    boxes_of: Experiment | None = None,
    fixes_late_s: float = 0.0,
    repeats: int = 1,
) -> Recording:
    """Return what a calibration is made from.

    Args:
        made: the flight.
        config: parameters.
        boxes_of: the flight that boxes are of.
        fixes_late_s: by so much everything but the gimbal is stamped late.
        repeats: so many samples have the values of the first of them.
    """
    recording = Recording(config or estimator_config({}))
    recording.add_camera(made.frames()[0].stamp_ns, made.camera)
    late_ns = round(fixes_late_s * 1e9)
    counts: Counter[Input] = Counter()
    first = {}
    for source, sample in telemetry(made.sensors):
        late = 0 if source is Input.GIMBAL else late_ns
        if counts[source] % repeats == 0:
            first[source] = sample
        counts[source] += 1
        deliver(recording, source, replace(first[source], stamp_ns=sample.stamp_ns + late))
    for _, _, boxes in (boxes_of or made).detections():
        recording.add_detections(boxes)
    return recording
