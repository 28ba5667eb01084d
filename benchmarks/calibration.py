# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Are the errors of a calibration as large as it says they are?

python benchmarks/calibration.py --flights 100 --markdown calibration.md --picture calibration.png

Flights of a minute over two to four robots: orbits, transits, hovers and pieces of a recorded
flight, robots that stay, swim, and both at once, 1 to 30 images and 1 to 50 samples of telemetry a
second, and any latency within 2.5 s. Sensors and boxes err as the consumer set says; nothing is
rendered. Of each constant: how often it was determined, error / stated sigma (root mean square,
largest, and how many lie within 3), and for the latency the Cramér-Rao bound
(`calibration_bound.py`). Flight number n is drawn from seed n.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from calibration_bound import bound
from numpy.typing import NDArray
from tables import keep

from aerial_gnss_ros.adapters.dji_log import read_dji_log
from aerial_gnss_ros.calibration.fit import Fit
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.calibration.search import MOST_IMAGES
from aerial_gnss_ros.calibration.solve import calibrate
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.feeding import feed
from aerial_gnss_ros.simulation.flight import Flight, FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.recorded import RecordedFlight, water_seconds
from aerial_gnss_ros.simulation.robots import Swarm, SwimPlan
from aerial_gnss_ros.simulation.sensors import sensor_plan

Array = NDArray[np.float64]

KINDS = ("orbit", "transit", "hover", "recorded")
SWIMS = ("still", "swimming", "mixed")
IMAGE_HZ, TELEMETRY_HZ = (1.0, 2.0, 10.0, 30.0), (1.0, 10.0, 50.0)
SLOW = ("heading", "gimbal_pitch", "gimbal_roll", "height")
DURATION_S = 60.0
LOG = Path(__file__).parents[2] / "shared" / "data" / "dji_tracking.csv"
CONFIG = {"gimbal": {"max_gap": 2.5}, "height": {"max_gap": 2.5}}


class Mixed(Swarm):
    """Robots of which every other one stays."""

    def _swim(self) -> tuple[Array, Array]:
        self.speeds[::2] = 0.0
        return super()._swim()


def experiment(number: int) -> tuple[Experiment, dict[str, Any]]:
    """Return one flight, and what it is."""
    rng = np.random.default_rng([number, 16])
    kind, swim = KINDS[number % 4], SWIMS[(number // 4) % 3]
    images, telemetry = rng.choice(IMAGE_HZ), rng.choice(TELEMETRY_HZ)
    latency = float(rng.uniform(-2.5, 2.5))
    height, speed = float(rng.uniform(12.0, 40.0)), float(rng.uniform(1.5, 4.0))
    flight: Flight
    if kind == "recorded":
        log = read_dji_log(LOG)
        starts = water_seconds(log, DURATION_S + 8.0)
        flight = RecordedFlight(log, float(rng.choice(starts)) + 4.0, DURATION_S)
    else:
        flight = GeneratedFlight(FlightPlan(kind, DURATION_S, height, speed_mps=speed), number)
    plan = replace(
        sensor_plan("consumer"), fix_hz=min(10.0, telemetry), height_hz=min(10.0, telemetry),
        gimbal_hz=telemetry, attitude_hz=telemetry,
    )  # fmt: skip
    fast = 0.0 if swim == "still" else 0.6
    slow = 0.0 if swim == "still" else 0.15
    made = Experiment(
        flight, default_camera(1280, 720), plan, CameraClock(images, latency),
        robots=int(rng.integers(2, 5)), swim=SwimPlan(slow, fast), seed=number,
    )  # fmt: skip
    if swim == "mixed":
        margin = 1.0 + abs(latency)
        made.swarm = Mixed(made.places, made.swim, number, -margin, DURATION_S + margin)
    about = {
        "number": number, "kind": kind, "swim": swim, "images_hz": float(images),
        "telemetry_hz": float(telemetry), "latency_s": latency,
    }  # fmt: skip
    return made, about


def record(made: Experiment, config: EstimatorConfig) -> Recording:
    """Return what a calibration is made from."""
    recording = Recording(config)
    recording.add_camera(made.frames()[0].stamp_ns, made.camera)
    feed(recording, made.sensors)
    for _, _, boxes in made.detections():
        recording.add_detections(boxes)
    return recording


def true(made: Experiment, name: str) -> float:
    """Return what a calibration should find, in the constant's unit."""
    if name == "latency":
        return made.clock.latency_s
    times = np.linspace(0.0, made.flight.duration_s, 100)
    return -float(np.mean(made.sensors.error(name, times))) if name in SLOW else 0.0


def flown(number: int) -> dict[str, Any]:
    """Return what one flight's calibration found."""
    config = estimator_config(CONFIG)
    made, about = experiment(number)
    recording = record(made, config)
    began = time.process_time()
    try:
        fit: Fit | None = calibrate(recording, config)
    except InputError as error:
        fit, about["refused"] = None, str(error)
    about["seconds"] = time.process_time() - began
    about["bound_s"] = bound(made, recording, MOST_IMAGES)
    about["found"] = {}
    if fit is not None:
        about |= {"trouble": list(fit.misfit), "doubts": fit.ambiguities, "pixel": fit.residual_px}
        about["speeds"] = list(fit.speeds_mps)
        for name in fit.names:
            value, sigma = fit.value(name)
            error = value - true(made, name)
            about["found"][name] = [error, sigma, fit.determined(name)]
    return about


def table(rows: list[dict[str, Any]]) -> list[str]:
    """Return the table of all flights."""
    lines = [
        "| constant | determined | rms error / sigma | largest | within 3 | rms error |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    units = {"latency": "s", "height": "m"}
    for name in ("latency", *SLOW):
        values = [row["found"][name] for row in rows if name in row["found"]]
        good = np.array([(error, sigma) for error, sigma, known in values if known]).reshape(-1, 2)
        if not len(good):
            lines.append(f"| {name.replace('_', ' ')} | 0 of {len(rows)} | | | | |")
            continue
        ratio = np.abs(good[:, 0] / good[:, 1])
        lines.append(
            f"| {name.replace('_', ' ')} | {len(good)} of {len(rows)} | "
            f"{np.sqrt(np.mean(ratio**2)):.2f} | {ratio.max():.1f} | "
            f"{int(np.sum(ratio <= 3.0))} of {len(ratio)} | "
            f"{np.sqrt(np.mean(good[:, 0] ** 2)):.3f} {units.get(name, 'deg')} |"
        )
    easy = [row for row in rows if row["bound_s"] < 0.02]
    told = [row for row in easy if row["found"].get("latency", (0, 0, False))[2]]
    off = [
        abs(row["found"]["latency"][0]) for row in rows
        if row["found"].get("latency", (0, 0, False))[2]
    ]  # fmt: skip
    lines += [
        "",
        (
            f"Latency determined in {len(told)} of {len(easy)} flights with a bound below 0.02 s; "
            f"largest error where determined {max(off, default=math.nan):.3f} s."
        ),
    ]
    return lines


def draw(rows: list[dict[str, Any]], path: Path) -> None:
    """Draw histograms of error / sigma of what was determined."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    names = ("latency", *SLOW)
    figure, axes = plt.subplots(1, len(names), figsize=(13, 2.6), sharey=True)
    grid = np.linspace(-5.0, 5.0, 200)
    for axis, name in zip(axes, names, strict=True):
        values = [row["found"][name] for row in rows if name in row["found"]]
        ratio = [error / sigma for error, sigma, known in values if known]
        axis.hist(np.clip(ratio, -5.0, 5.0), bins=np.arange(-5.0, 5.01, 0.5), color="#4878a8")
        axis.plot(grid, 0.5 * len(ratio) * np.exp(-0.5 * grid**2) / math.sqrt(2 * math.pi), "k")
        axis.set_title(f"{name.replace('_', ' ')} ({len(ratio)} determined)", fontsize=9)
        axis.set_xlabel("error / stated sigma")
    axes[0].set_ylabel("flights")
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def main() -> None:
    """Fly and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--flights", type=int, default=100, help="how many (default 100)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (default 0)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    parser.add_argument("--rows", type=Path, help="file of results, a line each, added to")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    parser.add_argument("--picture", type=Path, help="where to draw the errors")
    given = parser.parse_args()
    rows = []
    if given.rows and given.rows.exists():
        rows = [json.loads(line) for line in given.rows.read_text().splitlines()]
    done = {row["number"] for row in rows}
    wanted = [n for n in range(given.first, given.first + given.flights) if n not in done]
    if not LOG.exists():
        print(f"{LOG} is absent: flights of a recorded motion are left out")
        wanted = [n for n in wanted if KINDS[n % 4] != "recorded"]
    if given.jobs > 1:
        from concurrent.futures import ProcessPoolExecutor

        with ProcessPoolExecutor(given.jobs) as pool:
            results = pool.map(flown, wanted)
            rows += [_told(row, given.rows) for row in results]
    else:
        rows += [_told(flown(number), given.rows) for number in wanted]
    lines = table(rows)
    print("\n".join(lines))
    keep("\n".join(lines) + "\n", given.markdown)
    if given.picture:
        draw(rows, given.picture)


def _told(row: dict[str, Any], path: Path | None) -> dict[str, Any]:
    error, sigma, known = row["found"].get("latency", (math.nan, math.nan, False))
    print(
        f"{row['number']:3d} {row['kind']:8s} {row['swim']:8s} {row['images_hz']:4g} "
        f"{row['telemetry_hz']:4g} Hz: latency {row['latency_s']:+.2f} s, error {error:+.3f} +- "
        f"{sigma:.3f}{'' if known else ' (not determined)'}, bound {row['bound_s']:.3f}, "
        f"{row['seconds']:.1f} s {row.get('refused', '')}",
        flush=True,
    )
    if path:
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")
    return row


if __name__ == "__main__":
    main()
