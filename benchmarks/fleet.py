# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Several drones together: errors and covariances against the bound of all of their boxes.

python benchmarks/fleet.py --flown fleet.jsonl --seeds 4 --markdown docs/results/fleet.md
python benchmarks/fleet.py --grid --flown grid.jsonl --seeds 1 --markdown docs/results/fleet.md

Each flight is flown by each drone's own estimator, and what these see is joined. The receivers'
common share is 0, 0.5 and 1 in turn, while the filter assumes 0.5. `--flown` keeps the flights: a
run that was stopped goes on.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import textwrap
import time
from collections import Counter, defaultdict
from dataclasses import asdict, dataclass
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from fleet_flights import (
    LAST_S,
    OFTEN_ENOUGH_HZ,
    RTK,
    SHARES,
    TWO,
    Cell,
    config_of,
    drones_of,
    errors_at_end,
    own,
    trace,
    true_drone,
)
from tables import columns, show

from aerial_gnss_ros.core.fleet.fleet import Fleet, FleetUpdate
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.evaluation.bound import bound, joint_bound
from aerial_gnss_ros.simulation.experiment import Experiment
from aerial_gnss_ros.simulation.sensors import START_NS

FIRST_S = 5.0
"""Time that is given to find out which robots are one, s."""

WITHIN = 1.15
"""Greatest RMS error that is asked for, in bounds."""
CELLS = (
    Cell("hover", "opposite", 10.0, RTK),
    Cell("hover", "opposite", 30.0, TWO, 0.3),
    Cell("hover", "opposite", 80.0, TWO),
    Cell("hover", "far", 10.0, TWO),
    Cell("orbit", "opposite", 10.0, TWO, 0.3),
    Cell("orbit", "beside", 30.0, RTK),
    Cell("orbit", "above", 30.0, TWO, 0.3),
    Cell("transit", "opposite", 30.0, RTK, 0.3),
    Cell("hover", "opposite", 15.0, ("consumer", "rtk")),
    Cell("orbit", "opposite", 30.0, ("consumer",) * 4, 0.3),
    Cell("hover", "opposite", 30.0, RTK, told=True, duration_s=60.0),
    Cell("hover", "opposite", 30.0, RTK, told=True, robots=1, duration_s=60.0),
    Cell("hover", "opposite", 30.0, TWO, survey_m=0.05, rate_hz=OFTEN_ENOUGH_HZ),
)

MIXED = {"hover": "opposite", "orbit": "opposite", "mixed": "above"}
GRID = tuple(
    Cell(
        "orbit" if kind == "mixed" else kind,
        formation,
        height_m,
        ("consumer",) * drones,
        speed,
        rate_hz=OFTEN_ENOUGH_HZ,
    )
    for drones in (2, 4)
    for kind, formation in MIXED.items()
    for height_m in (10.0, 30.0, 80.0)
    for speed in (0.0, 0.3)
)
"""Two and four drones that hover or circle evenly around the robots, or one circles and the others
hover above."""


@dataclass(frozen=True)
class Record:
    """One flight.

    Attributes:
        cell: number of its kind.
        seed: of it.
        share: what receivers truly have in common.
        together: mean squared error of the fleet at the end, m².
        alone: the same of each drone's own estimator.
        bound: mean of the joint bound's trace there, m².
        bound_alone: of that of the first drone.
        nees: mean normalised squared error of the fleet, by its degrees of freedom.
        joined: number of robots under one name for all drones that saw them.
        names: number of names published from 5 s before the end on.
        ms: processor time of the fleet for a sighting, ms.
        agree: share of the drones' names, from 5 s on, that stand for the fleet's of that robot.
        told: as `together` where the filter is told the true share; NaN: not flown.
    """

    cell: int
    seed: int
    share: float
    together: float
    alone: tuple[float, ...]
    bound: float
    bound_alone: float
    nees: float
    joined: int
    names: int
    ms: float
    agree: float = math.nan
    told: float = math.nan


def fly(number: int, cell: Cell, seed: int, share: float) -> Record:
    """Return one flight's record."""
    made = drones_of(cell, seed, share)
    local = LocalMap(made["a"].flight.origin)
    last = [*made][-1]
    configs = {
        name: config_of(cell, noise, one.reference() if name == last else None)
        for (name, one), noise in zip(made.items(), cell.noises, strict=True)
    }
    sightings: list[tuple[int, str, Sighting]] = []
    alone: list[float] = []
    for name, one in made.items():
        results, seen = own(one, configs[name])
        alone.append(
            errors_at_end(made["a"], local, [r.estimates for r in results], cell.beacons)[0]
        )
        sightings += [(sighting.pose.stamp_ns, name, sighting) for sighting in seen]
    sightings.sort(key=lambda item: item[:2])
    fleet, began = Fleet(configs, local), time.process_time()
    updates = [(name, seen, fleet.update(name, seen)) for _, name, seen in sightings]
    spent = time.process_time() - began
    published = [update.estimates for _, _, update in updates]
    squared, nees = errors_at_end(made["a"], local, published, cell.beacons)
    told = math.nan
    if cell.beacons:
        sure = Fleet(configs, local, share)
        surely = [sure.update(name, seen).estimates for _, name, seen in sightings]
        told = errors_at_end(made["a"], local, surely, cell.beacons)[0]
    drones = [
        true_drone(one, configs[name], 0 if name == last else cell.beacons)
        for name, one in made.items()
    ]
    end = round(LAST_S * made["a"].clock.rate_hz)
    known = dict.fromkeys(range(cell.beacons), cell.survey_m)
    limits = joint_bound(drones, local, share, known)[0][-end:, cell.beacons :]
    first = bound(drones[0].config, drones[0].camera, drones[0].frames, local)[-end:]
    names = {
        one.robot_id
        for estimates in published[len(published) // 2 :]
        for one in estimates
        if one.class_id != "beacon"
    }
    return Record(
        number, seed, share, squared, tuple(alone), trace(limits), trace(first), nees,
        sum(len(robot.labels) == len(made) for robot in fleet.robots), len(names),
        1e3 * spent / len(sightings), agreement(made, updates), told,
    )  # fmt: skip


def agreement(
    made: dict[str, Experiment], updates: list[tuple[str, Sighting, FleetUpdate]]
) -> float:
    """Return the share of the drones' names that stand for the robot that the fleet's name does.

    A name of the fleet stands for the robot whose boxes it is used for most often, and a robot has
    one name: that which is used for it most often.
    """
    frames = {name: {f.stamp_ns: f for f in one.frames()} for name, one in made.items()}
    used = list[tuple[str | None, str]]()
    for name, seen, update in updates:
        if (seen.stamp_ns - START_NS) * 1e-9 < FIRST_S:
            continue
        true = made[name].projected(frames[name][seen.stamp_ns])
        for label, pixel in zip(seen.labels, seen.pixels, strict=True):
            if label:
                nearest = int(np.square(true.centers - pixel).sum(axis=1).argmin())
                used.append((update.names.get(label), str(true.names[nearest])))
    pairs = Counter(used)
    of_name, of_robot = dict[str | None, str](), dict[str, str | None]()
    for (name, robot), _ in pairs.most_common():
        if name is not None:
            of_name.setdefault(name, robot)
            of_robot.setdefault(robot, name)
    right = sum(
        count for (name, robot), count in pairs.items()
        if name is not None and of_name[name] == robot and of_robot[robot] == name
    )  # fmt: skip
    return right / max(len(used), 1)


HEADS = [
    "flight", "RMS, m", "bound, m", "RMS / bound", "alone, m", "gain", "bound's gain",
    "NEES/2: share 0", "0.5", "1", "joined", "names, %", "ms",
]  # fmt: skip


def row(words: str, records: list[Record], robots: int) -> list[str]:
    """Return the table's row of some flights."""

    def root(values: list[float]) -> float:
        return math.sqrt(float(np.mean(values)))

    both, limit = root([r.together for r in records]), root([r.bound for r in records])
    alone = root([r.alone[0] for r in records])
    nees = [f"{np.mean([r.nees for r in records if r.share == share]):.2f}" for share in SHARES]
    joined = sum(r.joined == robots and r.names == robots for r in records)
    return [
        words, f"{both:.3f}", f"{limit:.3f}", f"{both / limit:.2f}", f"{alone:.3f}",
        f"{alone / both:.2f}", f"{root([r.bound_alone for r in records]) / limit:.2f}", *nees,
        f"{joined} of {len(records)}", f"{100.0 * np.nanmean([r.agree for r in records]):.1f}",
        f"{np.mean([r.ms for r in records]):.1f}",
    ]  # fmt: skip


def pooled(rows: list[list[Record]]) -> str:
    """Return sentences on all flights, each by its own bound.

    Args:
        rows: flights of each kind.
    """
    records = [one for of in rows for one in of]
    ratio = math.sqrt(float(np.mean([r.together / r.bound for r in records])))
    nees = np.array([r.nees for r in records])
    error = float(nees.std(ddof=1)) / math.sqrt(len(nees)) if len(nees) > 1 else math.nan
    names = 100.0 * float(np.nanmean([r.agree for r in records]))
    words = (
        f"{len(records)} flights; over all of them, RMS / bound is {ratio:.2f}, NEES/2 "
        f"{nees.mean():.2f} (standard error {error:.2f}), and {names:.1f} % of the drones' names "
        "agree with the fleet's."
    )
    if not any(math.isnan(r.told) for r in records):
        sure = math.sqrt(float(np.mean([r.told / r.bound for r in records])))
        words += f" Where the filter is told the true share, RMS / bound is {sure:.2f}."
    if len(rows) == 1:
        return words
    means = [float(np.mean([r.nees for r in of])) for of in rows]
    ratios = [np.mean([r.together for r in of]) / np.mean([r.bound for r in of]) for of in rows]
    near = sum(float(one) <= WITHIN**2 for one in ratios)
    honest = sum(0.5 <= one <= 2.0 for one in means)
    return (
        f"{words} Of {len(rows)} rows, {near} are within {WITHIN:g} of the bound; NEES/2 over all "
        f"shares lies within 0.5 to 2 in {honest}."
    )


def main() -> int:
    """Fly what is missing and print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--seeds", type=int, default=4, help="of each cell and share (default 4)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (default 0)")
    parser.add_argument("--flown", type=Path, help="file that keeps the flights")
    parser.add_argument("--cells", type=int, nargs="*", help="numbers of cells (default all)")
    parser.add_argument("--grid", action="store_true", help="fly the grid of cells instead")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    records: dict[tuple[int, int], Record] = {}
    if given.flown is not None and given.flown.is_file():
        for line in given.flown.read_text(encoding="utf-8").splitlines():
            one = Record(**json.loads(line))
            records[one.cell, one.seed] = one
    cells, first = (GRID, 1_000_000) if given.grid else (CELLS, 0)
    chosen = range(len(cells)) if given.cells is None else given.cells
    for repeat in range(given.first, given.first + given.seeds):
        for number in chosen:
            for k, share in enumerate(SHARES):
                seed = first + 10_000 * (number + 1) + 10 * repeat + k
                if (number, seed) in records:
                    continue
                records[number, seed] = fly(number, cells[number], seed, share)
                if given.flown is not None:
                    with given.flown.open("a", encoding="utf-8") as kept:
                        kept.write(json.dumps(asdict(records[number, seed])) + "\n")
    of: dict[int, list[Record]] = defaultdict(list)
    for (number, _), one in sorted(records.items()):
        of[number].append(one)
    rows = [row(cells[n].words, found, cells[n].robots) for n, found in sorted(of.items())]
    show(f"{textwrap.fill(pooled([*of.values()]), 120)}\n\n" + columns(HEADS, rows), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
