# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A drone whose compass is 10 deg wrong from the beginning: when it is named, and what it harms.

python benchmarks/fleet_compass.py --flown compass.jsonl --markdown docs/results/fleet.md

Each drone has ten images a second. `--flown` keeps the flights: a run that was stopped goes on.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from fleet_flights import Cell, config_of, drones_of, errors_at_end, own
from fleet_names import robots_by_name, uses
from tables import columns, show

from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.fleet.fleet import Fleet
from aerial_gnss_ros.core.geometry.frames import (
    matrix_from_quaternion,
    matrix_from_rpy,
    quaternion_from_matrix,
)
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.simulation.sensors import START_NS

WRONG_DEG = 10.0
SOON_S = 10.0
"""Time within which it is to be named, s."""
CELLS = (
    Cell("hover", "opposite", 15.0, ("rtk",) * 2, duration_s=20.0),
    Cell("hover", "opposite", 15.0, ("consumer",) * 3, duration_s=20.0),
    Cell("orbit", "opposite", 30.0, ("consumer",) * 3, 0.3, duration_s=20.0),
    Cell("hover", "opposite", 15.0, ("consumer",) * 2, duration_s=20.0),
)


class Turned:
    """Passes telemetry on to an estimator with the compass turned."""

    def __init__(self, estimator: Estimator) -> None:
        self._estimator = estimator
        self._turn = matrix_from_rpy(0.0, 0.0, math.radians(WRONG_DEG))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._estimator, name)

    def add_gimbal(self, sample: Any) -> None:
        """Pass on a camera's orientation."""
        turned = self._turn @ matrix_from_quaternion(sample.quaternion)
        quaternion = quaternion_from_matrix(turned[None])[0]
        self._estimator.add_gimbal(replace(sample, quaternion=quaternion))


Flight = tuple[float, float, dict[str, tuple[str, float]], list[str]]


def flown(cell: Cell, seed: int, wrong: bool) -> Flight:
    """Return mean squared error, m², NEES/2 at the end, who was named when, s, who disagreed."""
    made = drones_of(cell, seed, 0.5)
    local = LocalMap(made["a"].flight.origin)
    configs = {name: config_of(cell, noise) for name, noise in zip(made, cell.noises, strict=True)}
    told = []
    for name, one in made.items():
        through = Turned if wrong and name == "b" else None
        told += [(s.pose.stamp_ns, name, s) for s in own(one, configs[name], through)[1]]
    told.sort(key=lambda item: item[:2])
    fleet, published, names = Fleet(configs, local), [], []
    named = dict[str, tuple[str, float]]()
    disagreed: set[str] = set()
    for _, name, seen in told:
        update = fleet.update(name, seen)
        published.append(update.estimates)
        names.append((name, seen, update.names))
        if update.report.fault:
            named.setdefault(name, (update.report.fault, (seen.stamp_ns - START_NS) * 1e-9))
        if update.report.disagrees:
            disagreed.add(name)
    robots = robots_by_name(uses(made, names))
    return *errors_at_end(made["a"], local, published, 0, robots), named, sorted(disagreed)


def main() -> int:
    """Fly what is missing and print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--seeds", type=int, default=4, help="of each cell (default 4)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (default 0)")
    parser.add_argument("--cells", type=int, nargs="*", help="numbers of cells (default all)")
    parser.add_argument("--flown", type=Path, help="file that keeps the flights")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    kept: dict[tuple[int, bool], Flight] = {}
    if given.flown is not None and given.flown.is_file():
        for line in given.flown.read_text(encoding="utf-8").splitlines():
            seed, spoiled, *found = json.loads(line)
            kept[seed, spoiled] = tuple(found)

    def flight(number: int, seed: int, spoiled: bool) -> Flight:
        if (seed, spoiled) not in kept:
            kept[seed, spoiled] = flown(CELLS[number], seed, spoiled)
            if given.flown is not None:
                with given.flown.open("a", encoding="utf-8") as file:
                    file.write(json.dumps([seed, spoiled, *kept[seed, spoiled]]) + "\n")
        return kept[seed, spoiled]

    rows = []
    for number in range(len(CELLS)) if given.cells is None else given.cells:
        cell = CELLS[number]
        first = 9_000_000 + 100 * number + given.first
        flights = range(first, first + given.seeds)
        right = [flight(number, seed, False) for seed in flights]
        wrong = [flight(number, seed, True) for seed in flights]
        times = [of["b"][1] for *_, of, _ in wrong if of.get("b", ("",))[0] == "compass"]
        others = sum(len(named) for *_, named, _ in right)
        others += sum(len(named.keys() - {"b"}) for *_, named, _ in wrong)
        rms = [math.sqrt(float(np.mean([one[0] for one in of]))) for of in (right, wrong)]
        rows.append(
            [
                f"{len(cell.noises)} drones, {cell.words.removeprefix('3 drones, ')}",
                f"{len(times)} of {given.seeds}",
                f"{sum(t <= SOON_S for t in times)} of {given.seeds}",
                f"{max(times):.1f}" if times else "-",
                str(others), f"{sum('b' in told for *_, told in wrong)} of {given.seeds}",
                f"{sum(bool(told) for *_, told in right)} of {given.seeds}",
                f"{rms[0]:.3f}", f"{rms[1]:.3f}",
                f"{np.mean([one[1] for one in wrong]):.2f}",
            ]
        )  # fmt: skip
    heads = [
        "flight",
        "named",
        "within 10 s",
        "latest, s",
        "others named",
        "disagrees",
        "without it",
        "RMS without it, m",
        "with it, m",
        "NEES/2",
    ]
    show(columns(heads, rows), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
