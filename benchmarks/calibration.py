# SPDX-License-Identifier: Apache-2.0
"""Are the errors of a calibration as large as it says they are?

python benchmarks/calibration.py --seeds 10 --markdown calibration.md

Two still robots, 20 m, an image each 0.25 s, the focal length asked for too. A transit or an orbit
takes 40 s; on a spiral the drone goes round twice in 80 s, from 8 m away and 14 m high to 26 m away
and 28 m high. Of each constant: root mean square and mean of error / stated sigma, where 1 and 0
are just right; root mean square of the error; median of the stated sigma; how often it was
determined. The ratio of n flights itself scatters by 1 / sqrt(2 n): by 0.22 with ten.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.calibration.fit import Fit, unknown
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.calibration.solve import calibrate
from aerial_gnss_ros.core.config import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.frames import matrix_from_rpy
from aerial_gnss_ros.simulation.experiment import (
    CameraClock,
    Experiment,
    default_camera,
)
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import sensor_plan

Array = NDArray[np.float64]

LATENCY_S = 0.1
KINDS = ("transit", "orbit", "spiral", "hover", "tilting hover")
RECEIVERS = ("consumer", "rtk")
SLOW = ("heading", "gimbal_pitch", "gimbal_roll", "height")


class Nod(GeneratedFlight):
    """A hover in which the gimbal tilts up and down, 15 deg to either side in 10 s."""

    def _camera(self, t: Array, camera: Array, yaw: Array) -> Array:
        tilt = math.radians(15.0) * np.sin(2.0 * np.pi * t / 10.0)
        turned: Array = super()._camera(t, camera, yaw) @ matrix_from_rpy(0.0, tilt, 0.0)
        return turned


class Spiral(GeneratedFlight):
    """Two rounds, from near and low to far and high."""

    def _share(self, t: Array) -> Array:
        return np.clip(t / self.plan.duration_s, -0.1, 1.1)

    def _position(self, t: Array) -> Array:
        rise = np.zeros((len(t), 3))
        rise[:, 2] = 14.0 * self._share(t) - 6.0
        return super()._position(t) + rise

    def _orbit(self, t: Array) -> Array:
        turned = self._bearing + self._turn * 4.0 * math.pi * t / self.plan.duration_s
        away = 8.0 + 18.0 * self._share(t)
        return -away[:, None] * np.column_stack([np.cos(turned), np.sin(turned)])


def experiment(kind: str, receiver: str, seed: int) -> Experiment:
    """Return one flight."""
    flight: GeneratedFlight
    if kind == "spiral":
        flight = Spiral(FlightPlan("orbit", 80.0, 20.0, speed_mps=3.0), seed)
    elif kind == "tilting hover":
        flight = Nod(FlightPlan("hover", 40.0, 20.0), seed)
    else:
        flight = GeneratedFlight(FlightPlan(kind, 40.0, 20.0, speed_mps=3.0), seed)
    return Experiment(
        flight, default_camera(1280, 720), sensor_plan(receiver), CameraClock(4.0, LATENCY_S),
        robots=2, swim=SwimPlan(0.0, 0.0), seed=seed,
    )  # fmt: skip


def record(made: Experiment, config: EstimatorConfig) -> Recording:
    """Return what a calibration is made from."""
    recording = Recording(config)
    sensors = made.sensors
    events = [(value.stamp_ns, 0, recording.add_fix, value) for value in sensors.fixes()]
    events += [(value.stamp_ns, 0, recording.add_gimbal, value) for value in sensors.gimbals()]
    events += [(value.stamp_ns, 0, recording.add_height, value) for value in sensors.heights()]
    for frame, _, boxes in made.detections():
        events.append((frame.log_ns, 1, recording.add_detections, boxes))
    events.sort(key=lambda event: event[:2])
    recording.add_camera(events[0][0], made.camera)
    for now_ns, is_image, take, value in events:
        take(value)
        if is_image:
            recording.advance(now_ns)
    recording.flush()
    return recording


def off(made: Experiment, fit: Fit, name: str) -> tuple[float, float, bool]:
    """Return error and sigma in the constant's unit, and whether it counts as determined."""
    times = np.linspace(0.0, made.flight.duration_s, 100)
    true = -float(np.mean(made.sensors.error(name, times))) if name in SLOW else 0.0
    value, sigma = fit.value(name)
    return value - true, sigma, fit.determined(name)


def line(kind: str, receiver: str, name: str, rows: list[tuple[float, float, bool]]) -> str:
    """Return one line of the table."""
    error, sigma, determined = np.array(rows, dtype=np.float64).T
    ratio = error / sigma
    unit = unknown(name).unit
    return (
        f"| {kind} {receiver} | {name.replace('_', ' ')} | {np.sqrt(np.mean(ratio**2)):.2f} | "
        f"{ratio.mean():+.2f} | {np.sqrt(np.mean(error**2)):.3f} {unit} | "
        f"{np.median(sigma):.3f} {unit} | {int(determined.sum())} of {len(rows)} |"
    )


def main() -> None:
    """Fly and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10, help="flights a row (default 10)")
    parser.add_argument("--flights", nargs="+", choices=KINDS, help="default: all")
    parser.add_argument("--receivers", nargs="+", choices=RECEIVERS, help="default: both")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    lines = [
        "| flight | constant | rms error / sigma | mean | rms error | sigma | determined |",
        "|---|---|---:|---:|---:|---:|---:|",
    ]
    for kind in given.flights or KINDS:
        for receiver in given.receivers or RECEIVERS:
            values = {"camera": {"latency_s": LATENCY_S}, "noise": {"set": receiver}}
            config = estimator_config(values)
            found: dict[str, list[tuple[float, float, bool]]] = {}
            for seed in range(1, given.seeds + 1):
                made = experiment(kind, receiver, seed)
                fit = calibrate(record(made, config), config, focal=True)
                for name in fit.names:
                    found.setdefault(name, []).append(off(made, fit, name))
            new = [line(kind, receiver, name, rows) for name, rows in found.items()]
            print("\n".join(new), flush=True)
            lines += new
    if given.markdown:
        given.markdown.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
