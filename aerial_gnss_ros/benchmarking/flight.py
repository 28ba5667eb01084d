# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The short flight played if no recording is given."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from aerial_gnss_ros.simulation.bag import write_bag
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.scene import demo_scene
from aerial_gnss_ros.simulation.sensors import sensor_plan

SECONDS = 4.0
IMAGE_HZ, TELEMETRY_HZ = 30.0, 50.0
HEIGHT_M = 15.0


def flight(robots: int, size: tuple[int, int], seed: int) -> Experiment:
    """Return an orbit around some robots, without latencies.

    Args:
        robots: number of robots.
        size: of the images, px.
        seed: of all random numbers.
    """
    plan = replace(
        sensor_plan("consumer"),
        fix_hz=TELEMETRY_HZ, attitude_hz=TELEMETRY_HZ, gimbal_hz=TELEMETRY_HZ,
        height_hz=TELEMETRY_HZ, fix_latency_s=0.0, attitude_latency_s=0.0, gimbal_latency_s=0.0,
        height_latency_s=0.0,
    )  # fmt: skip
    return Experiment(
        GeneratedFlight(FlightPlan("orbit", SECONDS, HEIGHT_M), seed), default_camera(*size), plan,
        CameraClock(IMAGE_HZ, delay_s=0.0), robots=robots, seed=seed,
    )  # fmt: skip


def render(experiment: Experiment, bag: Path, seed: int, report: Callable[[int], None]) -> None:
    """Write the flight with raw images.

    Raises:
        OutputError: it cannot be written.
    """
    write_bag(bag, experiment, demo_scene(seed), images="raw", report=report)
