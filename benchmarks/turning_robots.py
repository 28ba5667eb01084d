# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that turn back every few metres: is the filter worse than single images?

python benchmarks/turning_robots.py --markdown docs/results/live.md

The demo's flights with simulated boxes, default parameters, no reference. Errors are without that
of the drone's own receiver, which no method can observe: of each flight the median over robots and
images, and the root mean square. `NEES/2` has the covariance without the receiver's offset (1 is
right).
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import ORIGIN, Image, results, robots_of, truth
from numpy.typing import NDArray
from tables import columns, show

from aerial_gnss_ros.commands.demo import demo_experiment
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.config.noise import SETS
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.evaluation.bound import TrueFrame
from aerial_gnss_ros.simulation.experiment import Experiment
from aerial_gnss_ros.simulation.sensors import START_NS

Array = NDArray[np.float64]

METHODS = ("filter", "single")
HEADS = ["method", "median m", "RMS m", "NEES/2", "flights worse than single images"]


def relative(
    made: Experiment, images: list[Image], true: list[TrueFrame], method: str
) -> tuple[float, float, float]:
    """Return the median error, m, the mean square, m², and NEES/2 of one flight."""
    origin = {"map.latitude_deg": ORIGIN.latitude, "map.longitude_deg": ORIGIN.longitude}
    stated = {name: math.degrees(angle) for name, angle in origin.items()} | {"method": method}
    found = results(made, estimator_config(stated), images)
    names = robots_of(found, true)
    t = np.array([(frame.pose.stamp_ns - START_NS) * 1e-9 for frame in true])
    receiver = np.column_stack(
        [made.sensors.error(f"gnss_{axis}", t) for axis in ("east", "north")]
    )
    white = SETS["consumer"]["gnss_white_m"]
    offset = (SETS["consumer"]["gnss_offset_m"] ** 2 - white**2) * np.eye(2)
    squares, normalised = [], []
    for result, frame, own in zip(found, true, receiver, strict=True):
        for one in result.estimates:
            robot = names[one.robot_id]
            if one.state is not State.CONFIRMED or not frame.seen[robot]:
                continue
            error = one.position - frame.positions[robot] - own
            squares.append(float(error @ error))
            normalised.append(
                float(error @ np.linalg.solve(one.covariance[:2, :2] - offset, error))
            )
    return math.sqrt(np.median(squares)), float(np.mean(squares)), float(np.mean(normalised)) / 2.0


def main() -> None:
    """Fly and write the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--seeds", type=int, default=24, help="flights (default 24)")
    parser.add_argument("--first", type=int, default=33, help="the first one's seed (default 33)")
    parser.add_argument("--markdown", type=Path, help="page that takes the table")
    given = parser.parse_args()
    flights: dict[str, list[tuple[float, float, float]]] = {name: [] for name in METHODS}
    for seed in range(given.first, given.first + given.seeds):
        made = demo_experiment(30.0, 15.0, 3, seed)
        images = list(made.detections())
        true = truth(made, images)
        for method, flown in flights.items():
            flown.append(relative(made, images, true, method))
    single, rows = np.array(flights["single"]), []
    for method, flown in flights.items():
        each = np.array(flown)
        worse = f"{(each[:, 0] > single[:, 0]).sum()} of {len(each)}" if method != "single" else "–"
        medians, squares, normalised = each.mean(axis=0)
        rows.append(
            [method, f"{medians:.2f}", f"{math.sqrt(squares):.2f}", f"{normalised:.2f}", worse]
        )
    show(columns(HEADS, rows), given.markdown)


if __name__ == "__main__":
    main()
