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
from collections import defaultdict
from dataclasses import asdict
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
from fleet_best import Beside, beside_best
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
from fleet_names import agreement, robots_by_name, uses
from fleet_records import HEADS, Record, pooled, row
from tables import columns, show

from aerial_gnss_ros.core.fleet.fleet import Fleet
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.evaluation.bound import bound, joint_bound

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
    alone, results = list[float](), dict[str, list[FrameResult]]()
    for name, one in made.items():
        results[name], seen = own(one, configs[name])
        robots = robots_by_name(uses(made, [(name, sighting, None) for sighting in seen]))
        estimates = [result.estimates for result in results[name]]
        alone.append(errors_at_end(made["a"], local, estimates, cell.beacons, robots)[0])
        sightings += [(sighting.pose.stamp_ns, name, sighting) for sighting in seen]
    sightings.sort(key=lambda item: item[:2])
    fleet, began = Fleet(configs, local), time.process_time()
    updates = [(name, seen, fleet.update(name, seen)) for _, name, seen in sightings]
    spent = time.process_time() - began
    published = [update.estimates for _, _, update in updates]
    used = uses(made, [(name, seen, update.names) for name, seen, update in updates])
    robots = robots_by_name(used)
    squared, nees = errors_at_end(made["a"], local, published, cell.beacons, robots)
    told = math.nan
    if cell.beacons:
        sure = Fleet(configs, local, share)
        surely = [sure.update(name, seen).estimates for _, name, seen in sightings]
        told = errors_at_end(made["a"], local, surely, cell.beacons, robots)[0]
    drones = [
        true_drone(one, configs[name], 0 if name == last else cell.beacons)
        for name, one in made.items()
    ]
    end = round(LAST_S * made["a"].clock.rate_hz)
    known = dict.fromkeys(range(cell.beacons), cell.survey_m)
    limits = joint_bound(drones, local, share, known)[0][-end:, cell.beacons :]
    first = bound(drones[0].config, drones[0].camera, drones[0].frames, local)[-end:]
    beside = Beside(*[math.nan] * 5)
    if not cell.beacons:
        said = [(name, seen.stamp_ns, update.estimates) for name, seen, update in updates]
        beside = beside_best(made, configs, results, said, share, robots)
    names = {
        one.robot_id
        for estimates in published[len(published) // 2 :]
        for one in estimates
        if one.class_id != "beacon"
    }
    return Record(
        number, seed, share, squared, tuple(alone), trace(limits), trace(first), nees,
        sum(len(robot.labels) == len(made) for robot in fleet.table.robots), len(names),
        1e3 * spent / len(sightings), agreement(used), told,
        beside.best, beside.best_nees, beside.expected, beside.nees,
    )  # fmt: skip


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
