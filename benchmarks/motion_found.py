# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How well are robots known that stay, drift, leave or swim, where nobody says which do?

python benchmarks/motion_found.py --seeds 4 --markdown docs/results/accuracy.md

Flights of 60 s at 30 m over three robots, RTK receiver. `found`: nothing else is stated. `not
sought`: `tracks.find_moored: false`. `told`: it is stated which robots stay. RMS of the horizontal
error of all robots in view, each fifth of a second from 10 s on; NEES/2 of `found` over the same
positions (1 is right); `beyond`: share of them beyond a squared distance of 13.8 (one in a thousand
of a right covariance).
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import Cell, RandomSwimmers, Setting, config, experiment, results, robots_of, truth
from numpy.typing import NDArray
from tables import columns, show

from aerial_gnss_ros.core.values.estimates import FrameResult, State
from aerial_gnss_ros.simulation.chance import generator

Array = NDArray[np.float64]

FAMILIES = ("orbit", "transit")
FROM_S, EACH_S, BEYOND = 10.0, 0.2, 13.8
BEGINS_S, MPS2 = 20.0, 0.01
"""When a current begins to grow, and how fast: faster than currents do."""
LEAVES_S = 30.0
HEADS = ["motion", "flight", "told m", "not sought m", "found m", "NEES/2", "beyond"]


def velocities(motion: str, t: Array, seed: int, count: int) -> Array:
    """Return the robots' velocities (steps, n, 2) at times (steps,), m/s."""
    rng = generator(seed, f"motion {motion}")
    found = np.zeros((len(t), count, 2))
    if motion == "all drift":
        found[:] = rng.uniform(0.03, 0.5) * course(rng)
    elif motion == "a current begins":
        found[:] = MPS2 * np.clip(t - BEGINS_S, 0.0, None)[:, None, None] * course(rng)
    elif motion == "one leaves":
        found[t > LEAVES_S, 0] = rng.uniform(0.1, 0.6) * course(rng)
    elif motion == "on watch circles of 3 to 10 cm":
        radius, phase = rng.uniform(0.03, 0.1, count), rng.uniform(0.0, 2.0 * math.pi, count)
        rate = 2.0 * math.pi / rng.uniform(8.0, 30.0, count)
        angle = rate * t[:, None] + phase
        found[:] = (radius * rate)[:, None] * np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
    return found


def course(rng: np.random.Generator) -> Array:
    """Return a random direction (2,)."""
    angle = rng.uniform(-math.pi, math.pi)
    return np.array([math.cos(angle), math.sin(angle)])


MOTIONS = (
    "all stay", "two stay, one swims", "on watch circles of 3 to 10 cm", "all drift",
    "a current begins", "one leaves", "all swim",
)  # fmt: skip
AS_SUPPOSED = {"all swim": 0, "two stay, one swims": 2}
"""Motions of which the random swimmers have theirs, and how many of these stay."""
TOLD = {
    "all stay": {"noise.robot_acceleration": 0.0, "tracks.max_speed": 0.01},
    "two stay, one swims": {
        "classes.beacon.acceleration": 0.0,
        "classes.beacon.max_speed": 0.01,
    },
}


class Swimmers(RandomSwimmers):
    """Robots of one of the other motions."""

    def __init__(self, motion: str, places: Array, seed: int, duration_s: float) -> None:
        super().__init__(places, moving=False, seed=seed, duration_s=duration_s)
        speed = velocities(motion, self._t, seed, len(places))
        steps = 0.5 * (speed[1:] + speed[:-1]) * self.STEP_S
        self._path[1:] = self._path[0] + np.cumsum(steps, axis=0)


class Flight:
    """Squared errors, m², and normalised ones, of one flight by what was stated."""

    def __init__(self, motion: str, family: str, seed: int) -> None:
        cell = Cell(family, 30.0, "rtk", moving=True)
        setting = Setting(beacons=AS_SUPPOSED.get(motion, 0))
        self._made = experiment(cell, seed, setting)
        if motion not in AS_SUPPOSED:
            places = np.asarray(self._made.places)
            self._made.swarm = Swimmers(motion, places, seed, setting.duration_s)
        self._images = list(self._made.detections())
        self._true = truth(self._made, self._images)
        self.squares: dict[str, list[float]] = {}
        self.normalised: dict[str, list[float]] = {}
        if motion in TOLD:
            self._fly("told", cell, Setting(stated=dict(TOLD[motion])))
        self._fly("not sought", cell, Setting(stated={"tracks.find_moored": False}))
        self._fly("found", cell, Setting())

    def _fly(self, name: str, cell: Cell, setting: Setting) -> None:
        found = results(self._made, config(cell, setting), self._images)
        self.squares[name], self.normalised[name] = self._errors(found)

    def _errors(self, found: list[FrameResult]) -> tuple[list[float], list[float]]:
        names, start = robots_of(found, self._true), self._true[0].pose.stamp_ns
        squares, normalised = [], []
        for result, frame in zip(found, self._true, strict=True):
            t = (frame.pose.stamp_ns - start) * 1e-9
            if t < FROM_S or abs(t / EACH_S - round(t / EACH_S)) > 1e-6:
                continue
            for one in result.estimates:
                robot = names[one.robot_id]
                if one.state is State.CONFIRMED and frame.seen[robot]:
                    error = one.position - frame.positions[robot]
                    squares.append(float(error @ error))
                    normalised.append(float(error @ np.linalg.solve(one.covariance[:2, :2], error)))
        return squares, normalised


def row(motion: str, family: str, flights: list[Flight]) -> list[str]:
    """Return one line of the table."""
    cells = [motion, f"{family} 30 m"]
    for name in ("told", "not sought", "found"):
        squares = [value for one in flights for value in one.squares.get(name, [])]
        cells.append(f"{math.sqrt(np.mean(squares)):.3f}" if squares else "–")
    normalised = np.array([value for one in flights for value in one.normalised["found"]])
    beyond = 100.0 * np.mean(normalised > BEYOND)
    return [*cells, f"{normalised.mean() / 2.0:.2f}", f"{beyond:.1f} %"]


def main() -> None:
    """Fly and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=4, help="flights a row (default 4)")
    parser.add_argument("--first", type=int, default=0, help="the first one's seed (default 0)")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    rows = []
    for motion in MOTIONS:
        for family in FAMILIES:
            seeds = range(given.first, given.first + given.seeds)
            rows.append(row(motion, family, [Flight(motion, family, seed) for seed in seeds]))
            print(" | ".join(rows[-1]), flush=True)
    show(columns(HEADS, rows), given.markdown)


if __name__ == "__main__":
    main()
