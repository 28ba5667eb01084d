# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Flies the families and keeps each flight's figures: one line of JSON a flight.

`consistency.py` and `accuracy.py` make their tables of the same flights. A file of flights that are
done is taken up again: only what lacks is flown, all cells of one seed before the next seed, so
that a run which is stopped leaves as many flights of each cell.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
import released_code
from families import (
    ORIGIN,
    Cell,
    Setting,
    bounds,
    cells,
    config,
    experiment,
    results,
    robots_of,
    truth,
)
from scipy.optimize import linear_sum_assignment
from tables import show

from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.georeferencing import localization, paper
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult, State
from aerial_gnss_ros.simulation.boxes import Boxes
from aerial_gnss_ros.simulation.experiment import Experiment

TIMES_S = (10.0, 30.0, 60.0)
METHODS = ("released", "paper", "single", "ours", "bound", "published")
MOST_M = 1000.0
"""An error beyond counts as this."""

Record = dict[str, object]


def fly(cell: Cell, seed: int, setting: Setting) -> Record:
    """Return the figures of one flight.

    `nees`: by time (s), of the chosen robot; absent where it is not in view. `nees_all`: of all
    robots at these times. `squares`: sums of squared errors (m²) by method over all robots with a
    box, each second from 10 s on; for `bound` and `published` of the covariances' traces.
    `samples`: how many. `extra_names`: published names less robots seen. `core_ms`: of an image.
    """
    made, stated = experiment(cell, seed, setting), config(cell, setting)
    images = list(made.detections())
    true = truth(made, images)
    found = results(made, stated, images)
    limits = bounds(made, stated, true)
    names = robots_of(found, true)
    methods = Methods(made, stated)
    times = [round((f.pose.stamp_ns - true[0].pose.stamp_ns) * 1e-9, 3) for f in true]
    nees: dict[str, float] = {}
    every: list[float] = []
    squares, samples = dict.fromkeys(METHODS, 0.0), 0
    for k, t in enumerate(times):
        at = next((one for one in TIMES_S if abs(min(one, times[-1]) - t) < 1e-6), None)
        if at is None and (t < TIMES_S[0] or abs(t - round(t)) > 1e-6):
            continue
        single = methods.places(found[k], images[k][1], images[k][2])
        for estimate in found[k].estimates:
            robot = names[estimate.robot_id]
            if estimate.state is not State.CONFIRMED or not true[k].seen[robot]:
                continue
            here, covariance = true[k].positions[robot], estimate.covariance[:2, :2]
            error = estimate.position - here
            if at is not None:
                every.append(float(error @ np.linalg.solve(covariance, error)))
                if robot == seed % setting.robots:
                    nees[f"{at:g}"] = every[-1]
            if robot not in single:
                continue
            samples += 1
            for method, place in single[robot].items():
                off = np.nan_to_num(np.linalg.norm(place - here), nan=MOST_M)
                squares[method] += min(float(off), MOST_M) ** 2
            squares["ours"] += float(error @ error)
            squares["bound"] += float(np.trace(limits[k, robot, :2, :2]))
            squares["published"] += float(np.trace(covariance))
    seen = int(np.any([frame.seen for frame in true], axis=0).sum())
    return {
        "cell": cell.words, "seed": seed, "nees": nees, "nees_all": every, "squares": squares,
        "samples": samples, "extra_names": len(names) - seen,
        "core_ms": float(np.median([sum(result.timings_ms.values()) for result in found])),
    }  # fmt: skip


class Methods:
    """The methods that take each image by itself; they are given the data association."""

    def __init__(self, made: Experiment, stated: object) -> None:
        self._made, self._stated = made, stated
        self._local = LocalMap(ORIGIN)
        self._attitudes = list(made.sensors.attitudes())
        self._stamps = np.array([attitude.stamp_ns for attitude in self._attitudes])

    def places(
        self, result: FrameResult, boxes: Boxes, frame: DetectionFrame
    ) -> dict[int, dict[str, np.ndarray]]:
        """Return East, North by robot and method, of robots with a box that gives a place."""
        pose, made, stated = result.pose, self._made, self._stated
        if pose is None or not len(frame):
            return {}
        body = self._attitudes[int(np.argmin(np.abs(self._stamps - pose.stamp_ns)))]
        exact = localization.locate(pose, made.camera, frame.centers, stated.noise, stated)
        printed = paper.locate(pose, made.camera, frame.centers, stated.noise, stated)
        released = released_code.locate(
            pose, made.camera, frame.centers, frame.sizes, matrix_from_quaternion(body.quaternion)
        )
        places = {
            "released": self._local.positions(*released),
            "paper": self._local.positions(printed.latitude, printed.longitude),
            "single": self._local.positions(exact.latitude, exact.longitude),
        }
        apart = np.linalg.norm(boxes.centers[:, None] - frame.centers[None], axis=2)
        return {
            made.swarm.names.index(boxes.names[row]): {
                method: found[column] for method, found in places.items()
            }
            for row, column in zip(*linear_sum_assignment(apart), strict=True)
            if exact.reasons[column] is None
        }


def arguments(words: str) -> argparse.ArgumentParser:
    """Return the options that both tables have."""
    parser = argparse.ArgumentParser(description=words)
    parser.add_argument("--flights", type=Path, required=True,
                        help="file of flights done, JSON lines; goes on where it ends")  # fmt: skip
    parser.add_argument("--seeds", type=int, default=100, help="flights a cell (default 100)")
    parser.add_argument("--first", type=int, default=0, help="the first one's seed (default 0)")
    parser.add_argument("--minutes", type=float, default=math.inf,
                        help="begin no flight later than this")  # fmt: skip
    parser.add_argument(
        "--only", default="", help="cells whose words hold all these, comma between"
    )
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    return parser


def chosen(only: str) -> list[Cell]:
    """Return the cells whose words hold all of some, comma between."""
    wanted = [part.strip() for part in only.split(",") if part.strip()]
    return [cell for cell in cells() if all(part in cell.words for part in wanted)]


def flown(given: argparse.Namespace) -> dict[str, list[Record]]:
    """Fly what lacks and return all flights by cell, of seeds that every cell has."""
    done = {(str(one["cell"]), int(str(one["seed"]))): one for one in _read(given.flights)}
    wanted, until = chosen(given.only), time.monotonic() + 60.0 * given.minutes
    seeds = range(given.first, given.first + given.seeds)
    for seed, cell in ((seed, cell) for seed in seeds for cell in wanted):
        if (cell.words, seed) in done or time.monotonic() > until:
            continue
        record = done[cell.words, seed] = fly(cell, seed, Setting())
        with given.flights.open("a", encoding="utf-8") as file:
            file.write(json.dumps(record) + "\n")
        print(f"{cell.words}, seed {seed}", file=sys.stderr, flush=True)
    whole = [seed for seed in seeds if all((cell.words, seed) in done for cell in wanted)]
    return {cell.words: [done[cell.words, seed] for seed in whole] for cell in wanted}


def write_table(words: str, markdown: Callable[[dict[str, list[Record]]], str]) -> int:
    """Fly as the command line says, print and keep the table; return the exit status.

    Args:
        words: what the program does, for its help.
        markdown: makes the table of the flights by cell.
    """
    given = arguments(words).parse_args()
    flights = flown(given)
    if not all(flights.values()):
        print("No seed has been flown in all of these families yet.", file=sys.stderr)
        return 1
    table = f"Seeds: {len(next(iter(flights.values())))}\n\n{markdown(flights)}"
    show(table, given.markdown)
    return 0


def _read(path: Path) -> Iterator[Record]:
    if path.exists():
        for line in path.read_text(encoding="utf-8").splitlines():
            yield json.loads(line)


def rms(flights: list[Record], method: str) -> float:
    """Return the root of a method's mean square over all samples, m; NaN without one."""
    samples = sum(one["samples"] for one in flights)  # type: ignore[misc]
    total = sum(one["squares"][method] for one in flights)  # type: ignore[index]
    return math.sqrt(total / samples) if samples else math.nan
