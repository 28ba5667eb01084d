# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Slow errors that last half a minute, of which nobody tells the filter: alone and together.

python benchmarks/fleet_lasting.py --first 20 --flown lasting.jsonl --markdown docs/results/fleet.md

Two drones with RTK on opposite sides of three robots; the filter is told that errors of compass,
gimbal, height and receiver last 300 s. `--flown` keeps the flights.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from fleet_flights import OFTEN_ENOUGH_HZ, RTK, Cell, config_of, drones_of, own
from fleet_still import errors
from tables import columns, show

from aerial_gnss_ros.core.fleet.fleet import Fleet
from aerial_gnss_ros.core.geometry.geodesy import LocalMap

LASTS_S = (300.0, 30.0)
CELLS = tuple(
    Cell(kind, "opposite", 30.0, RTK, speed, duration_s=90.0, rate_hz=OFTEN_ENOUGH_HZ, lasts_s=long)
    for kind in ("hover", "orbit")
    for speed in (0.0, 0.3)
    for long in LASTS_S
)


def flown(cell: Cell, seed: int) -> list[float]:
    """Return the errors of a flight.

    Mean squared errors, m², NEES/2 and the share far beyond: of each drone's own estimator on
    average, then of all together.
    """
    made = drones_of(cell, seed, 0.5)
    local = LocalMap(made["a"].flight.origin)
    configs = {
        name: config_of(cell, noise, find_moored=True)
        for name, noise in zip(made, cell.noises, strict=True)
    }
    alone, told = list[list[float]](), []
    for name, one in made.items():
        results, seen = own(one, configs[name])
        alone.append(errors(made["a"], local, [r.estimates for r in results]))
        told += [(each.pose.stamp_ns, name, each) for each in seen]
    told.sort(key=lambda item: item[:2])
    fleet = Fleet(configs, local)
    published = [fleet.update(name, seen).estimates for _, name, seen in told]
    mean: list[float] = np.mean(alone, axis=0).tolist()
    return [*mean, *errors(made["a"], local, published)]


def main() -> int:
    """Fly what is missing and print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--seeds", type=int, default=6, help="of each row (default 6)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (default 0)")
    parser.add_argument("--flown", type=Path, help="file that keeps the flights")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    kept = dict[tuple[int, int], list[float]]()
    if given.flown is not None and given.flown.is_file():
        for line in given.flown.read_text(encoding="utf-8").splitlines():
            number, seed, *one = json.loads(line)
            kept[number, seed] = one
    for seed in range(6_000_000 + given.first, 6_000_000 + given.first + given.seeds):
        for number, cell in enumerate(CELLS):
            if (number, seed) in kept:
                continue
            kept[number, seed] = flown(cell, seed)
            if given.flown is not None:
                with given.flown.open("a", encoding="utf-8") as file:
                    file.write(json.dumps([number, seed, *kept[number, seed]]) + "\n")
    rows = []
    for number, cell in enumerate(CELLS):
        each = [one for key, one in kept.items() if key[0] == number]
        if not each:
            continue
        means = np.mean(each, axis=0).tolist()
        alone, together = math.sqrt(means[0]), math.sqrt(means[3])
        rows.append(
            [
                f"{cell.kind}, {'swimming' if cell.speed else 'still'}", f"{cell.lasts_s:g}",
                str(len(each)), f"{alone:.3f}", f"{together:.3f}", f"{alone / together:.2f}",
                f"{means[1]:.2f}", f"{means[4]:.2f}", f"{100.0 * means[2]:.2f} %",
                f"{100.0 * means[5]:.2f} %",
            ]
        )  # fmt: skip
    heads = [
        "flight", "errors last, s", "flights", "alone, m", "together, m", "gain", "NEES/2 alone",
        "together", "beyond alone", "together",
    ]  # fmt: skip
    show(columns(heads, rows), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
