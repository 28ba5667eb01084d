# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that stay, which nobody tells the filter: a drone alone finds out, a fleet does not.

python benchmarks/fleet_still.py --markdown docs/results/fleet.md

Receivers have half of their variance in common.
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import replace
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from fleet_flights import RTK, TWO, Cell, config_of, drones_of, errors_at_end, own
from tables import columns, show

from aerial_gnss_ros.core.fleet.fleet import Fleet
from aerial_gnss_ros.core.geometry.geodesy import LocalMap

CELLS = (
    Cell("hover", "opposite", 30.0, RTK, duration_s=60.0),
    Cell("orbit", "opposite", 30.0, RTK, duration_s=40.0),
    Cell("hover", "opposite", 30.0, TWO, duration_s=60.0),
)


def flown(cell: Cell, seed: int) -> list[float]:
    """Return mean squared errors of a flight, m².

    Those of each drone's own estimator, by default and without its search, and of all together.
    """
    made = drones_of(cell, seed, 0.5)
    local = LocalMap(made["a"].flight.origin)
    swim = {name: config_of(cell, noise) for name, noise in zip(made, cell.noises, strict=True)}
    default, plain, told = list[float](), list[float](), []
    for name, one in made.items():
        search = replace(swim[name].tracks, find_moored=True)
        results = own(one, replace(swim[name], tracks=search))[0]
        default.append(errors_at_end(made["a"], local, [r.estimates for r in results])[0])
        results, sightings = own(one, swim[name])
        plain.append(errors_at_end(made["a"], local, [r.estimates for r in results])[0])
        told += [(seen.pose.stamp_ns, name, seen) for seen in sightings]
    told.sort(key=lambda item: item[:2])
    fleet = Fleet(swim, local)
    published = [fleet.update(name, seen).estimates for _, name, seen in told]
    together = errors_at_end(made["a"], local, published)[0]
    return [float(np.mean(default)), float(np.mean(plain)), together]


def main() -> int:
    """Fly and print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--seeds", type=int, default=2, help="of each cell (default 2)")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    rows = []
    for number, cell in enumerate(CELLS):
        first = 5_000_001 + 1000 * number
        seeds = range(first, first + given.seeds)
        squared = np.mean([flown(cell, seed) for seed in seeds], axis=0)
        rows.append([cell.words, str(given.seeds), *(f"{math.sqrt(one):.3f}" for one in squared)])
    heads = ["flight", "flights", "alone, m", "alone, without the search, m", "together, m"]
    show(columns(heads, rows), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
