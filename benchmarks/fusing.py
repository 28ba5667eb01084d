# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Does a robot's own filter stay honest with our positions? docs/results/fusing.md.

python benchmarks/fusing.py --seeds 100 --flown fusing.jsonl --markdown docs/results/fusing.md
python benchmarks/fusing.py --parts --seeds 24 --flown parts.jsonl --markdown docs/results/fusing.md

Simulated flights of 46 minutes over a swimming robot, a consumer receiver, an image a second and
telemetry at 5 Hz. The robot has a Kalman filter of its own, which takes every position that it is
given as independent of the others, and dead reckoning between them: its true displacement with
white noise, which it knows. NEES is e' P^-1 e of that filter's East and North; 2 is expected. The
band is at 95 % over the times of a row together (Bonferroni).

--parts: flights of ten minutes, two images a second, over a robot whose filter has two more states,
the shared offset, and takes the white part of each position (`updates.covariance_parts`).
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import ORIGIN, results, robots_of, truth
from scipy.stats import chi2
from tables import columns, show

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.config.processing import UpdatesConfig
from aerial_gnss_ros.core.estimation.position_updates import PositionUpdates
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate, State
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import sensor_plan

DURATION_S = 2760.0
TIMES_S = (300.0, 1200.0, 2700.0)
PARTS_S, EVERY = 600.0, (1, 2, 5, 10)
TIME_S = 300.0  # correlation time of the consumer set
WALKS = {"0.01": 0.01, "0.1": 0.1, "1": 1.0}
"""Random walk of dead reckoning, m per root second: a Doppler log; a compass and a thruster model;
hardly anything. Over ten minutes 0.25, 2.5 and 25 m."""
WAYS = {
    "every image": None,
    "one in 30 s, as `fix` states it": 30.0,
    "`position_update`, 30 s": UpdatesConfig(interval_s=30.0),
    "`position_update`, 300 s": UpdatesConfig(interval_s=300.0),
    "`position_update` (900 s)": UpdatesConfig(),
}


class Seldom:
    """Positions as `fix` has them, every so many seconds."""

    def __init__(self, seconds: float) -> None:
        self._step_ns = round(seconds * 1e9)
        self._last: dict[str, int] = {}

    def due(self, result: FrameResult) -> list[RobotEstimate]:
        """Return those that are due."""
        due = [
            one
            for one in result.estimates
            if one.state is State.CONFIRMED
            and one.stamp_ns - self._last.get(one.robot_id, -self._step_ns) >= self._step_ns
        ]
        self._last |= {one.robot_id: one.stamp_ns for one in due}
        return due


def flown(
    seed: int, duration_s: float, rate_hz: float, parts: bool
) -> tuple[list[FrameResult], np.ndarray, np.ndarray, int]:
    """Return results of a flight, the robot's true path (n, 2), stamps (n,) and count of labels."""
    made = Experiment(
        GeneratedFlight(FlightPlan(kind="hover", duration_s=duration_s, height_m=30.0), seed),
        default_camera(1280, 720),
        replace(sensor_plan("consumer"), fix_hz=5.0, attitude_hz=5.0, gimbal_hz=5.0, height_hz=5.0),
        CameraClock(rate_hz=rate_hz),
        robots=1,
        swim=SwimPlan(),
        seed=seed,
    )
    stated = estimator_config(
        {
            "map.latitude_deg": np.degrees(ORIGIN.latitude),
            "map.longitude_deg": np.degrees(ORIGIN.longitude),
            "updates.covariance_parts": parts,
        }
    )
    images = list(made.detections())
    true = truth(made, images)
    found = results(made, stated, images)
    path = np.array([frame.positions[0] for frame in true])
    stamps = np.array([frame.pose.stamp_ns for frame in true])
    return found, path, stamps, len(robots_of(found, true))


def fly(seed: int) -> dict[str, object]:
    """Return NEES of one robot's filter by way, walk and time."""
    found, path, stamps, names = flown(seed, DURATION_S, 1.0, parts=False)
    nees = {
        f"{way} {walk}": follow(way, walk, found, path, stamps, seed)
        for way in WAYS
        for walk in WALKS
    }
    return {"seed": seed, "names": names, "nees": nees}


def fly_parts(seed: int) -> dict[str, object]:
    """Return NEES of a filter with the shared offset, at the end, by images and walk."""
    found, path, stamps, names = flown(seed, PARTS_S, 2.0, parts=True)
    nees = {
        f"{every} {walk}": follow_offset(every, walk, found, path, stamps, seed)
        for every in EVERY
        for walk in WALKS
    }
    return {"seed": seed, "names": names, "nees": nees}


def follow_offset(
    every: int,
    walk: str,
    found: list[FrameResult],
    path: np.ndarray,
    stamps: np.ndarray,
    seed: int,
) -> float:
    """Return NEES of the position at the end: state East, North and the offset of both."""
    rng = np.random.default_rng([seed, list(WALKS).index(walk)])
    mean, covariance, shared = np.zeros(4), np.zeros((4, 4)), np.zeros((2, 2))
    seen = np.hstack([np.eye(2), np.eye(2)])  # a position is the robot's and the offset
    count = 0
    for k, result in enumerate(found):
        if count:
            step_s = (stamps[k] - stamps[k - 1]) * 1e-9
            keep, noise = np.exp(-step_s / TIME_S), WALKS[walk] * np.sqrt(step_s)
            fade = np.diag([1.0, 1.0, keep, keep])
            mean = fade @ mean
            mean[:2] += path[k] - path[k - 1] + noise * rng.normal(size=2)
            covariance = fade @ covariance @ fade
            covariance[:2, :2] += noise**2 * np.eye(2)
            covariance[2:, 2:] += (1.0 - keep**2) * shared
        for one in result.estimates:
            if one.state is not State.CONFIRMED or one.white is None:
                continue
            shared = one.covariance[:2, :2] - one.white
            count += 1
            if count == 1:
                mean[:2] = one.position
                covariance[:2, :2], covariance[2:, 2:] = one.covariance[:2, :2], shared
                covariance[:2, 2:] = covariance[2:, :2] = -shared
            elif count % every == 0:
                gain = covariance @ seen.T @ np.linalg.inv(seen @ covariance @ seen.T + one.white)
                mean = mean + gain @ (one.position - seen @ mean)
                covariance = (np.eye(4) - gain @ seen) @ covariance
    error = mean[:2] - path[-1]
    return float(error @ np.linalg.solve(covariance[:2, :2], error))


def follow(
    way: str,
    walk: str,
    found: list[FrameResult],
    path: np.ndarray,
    stamps: np.ndarray,
    seed: int,
) -> dict[str, float]:
    """Return NEES at `TIMES_S` of a filter that is given positions in one way."""
    config = WAYS[way]
    if isinstance(config, UpdatesConfig):
        source: PositionUpdates | Seldom = PositionUpdates(config, TIME_S)
    else:
        source = Seldom(config or 0.0)
    rng = np.random.default_rng([seed, list(WALKS).index(walk)])
    mean, covariance, former = None, np.zeros((2, 2)), stamps[0]
    nees: dict[str, float] = {}
    for k, result in enumerate(found):
        step_s = (stamps[k] - former) * 1e-9
        former = stamps[k]
        if mean is not None:
            noise = WALKS[walk] * np.sqrt(step_s)
            mean = mean + path[k] - path[k - 1] + noise * rng.normal(size=2)
            covariance = covariance + noise**2 * np.eye(2)
        for one in source.due(result):
            if mean is None:
                mean, covariance = one.position, one.covariance[:2, :2]
                continue
            gain = covariance @ np.linalg.inv(covariance + one.covariance[:2, :2])
            mean = mean + gain @ (one.position - mean)
            covariance = (np.eye(2) - gain) @ covariance
        t = (stamps[k] - stamps[0]) * 1e-9
        for wanted in TIMES_S:
            if mean is not None and f"{wanted:g}" not in nees and t >= wanted:
                error = mean - path[k]
                nees[f"{wanted:g}"] = float(error @ np.linalg.solve(covariance, error))
    return nees


def table_parts(flights: list[dict[str, object]]) -> str:
    """Return mean NEES at the end by images and walk."""
    low, high = chi2.ppf([0.025, 0.975], 2 * len(flights)) / len(flights)
    rows = []
    for every in EVERY:
        for walk in WALKS:
            mean = float(np.mean([one["nees"][f"{every} {walk}"] for one in flights]))  # type: ignore[index]
            words = "too small" if mean < low else "TOO LARGE" if mean > high else "yes"
            rows.append([f"one in {every}" if every > 1 else "each", walk, f"{mean:.2f}", words])
    heads = ["images", "dead reckoning, m/√s", "NEES after 10 min", f"in {low:.2f} to {high:.2f}"]
    return f"{len(flights)} flights.\n\n" + columns(heads, rows)


def table(flights: list[dict[str, object]]) -> str:
    """Return mean NEES by way and walk."""
    heads = ["positions given", "dead reckoning, m/√s",
             *(f"NEES after {t / 60:g} min" for t in TIMES_S), "in band"]  # fmt: skip
    rows = []
    for way in WAYS:
        for walk in WALKS:
            means, outside = [], set()
            for t in TIMES_S:
                values = [one["nees"][f"{way} {walk}"].get(f"{t:g}") for one in flights]  # type: ignore[index]
                values = [value for value in values if value is not None]
                mean, count = float(np.mean(values)), len(values)
                tail = 0.05 / len(TIMES_S) / 2.0
                low, high = chi2.ppf([tail, 1.0 - tail], 2 * count) / count
                means.append(f"{mean:.2f}")
                outside |= {"too small"} if mean < low else {"TOO LARGE"} if mean > high else set()
            rows.append([way, walk, *means, ", ".join(sorted(outside)) or "yes"])
    return f"{len(flights)} flights.\n\n" + columns(heads, rows)


def main() -> int:
    """Fly what lacks and write the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument(
        "--seeds",
        type=int,
        default=100,
        help="flights to fly (default 100); the table is of all in the file",
    )
    parser.add_argument("--first", type=int, default=0, help="seed of the first one (default 0)")
    parser.add_argument("--flown", type=Path, required=True, help="file of flights, taken up again")
    parser.add_argument("--markdown", type=Path, help="page with a place for the table")
    parser.add_argument("--parts", action="store_true", help="both parts of the covariance")
    given = parser.parse_args()
    fly_one, show_all = (fly_parts, table_parts) if given.parts else (fly, table)
    lines = given.flown.read_text().splitlines() if given.flown.is_file() else []
    flights = {record["seed"]: record for record in map(json.loads, lines)}
    for seed in range(given.first, given.first + given.seeds):
        if seed not in flights:
            flights[seed] = fly_one(seed)
            with given.flown.open("a", encoding="utf-8") as file:
                file.write(json.dumps(flights[seed]) + "\n")
    show(show_all([flights[seed] for seed in sorted(flights)]), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
