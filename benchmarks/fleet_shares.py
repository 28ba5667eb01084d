# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What it costs to assume a wrong common share of the receivers' variance.

python benchmarks/fleet_shares.py --markdown docs/results/fleet.md

Each flight of two drones, whose receivers have a share of 0, 0.5 or 1 in common, is joined three
times: by a filter that is sure that the share is 0, or 1, and by one that expects 0.5 and lets the
data change it. Three images a second.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections import defaultdict
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from fleet_flights import SHARES, Cell, config_of, drones_of, errors_at_end, own
from tables import columns, show

from aerial_gnss_ros.core.fleet.fleet import Fleet
from aerial_gnss_ros.core.geometry.geodesy import LocalMap

CELLS = (
    Cell("hover", "opposite", 30.0, ("consumer",) * 2, duration_s=16.0, rate_hz=3.0),
    Cell("orbit", "opposite", 30.0, ("consumer",) * 2, 0.3, duration_s=16.0, rate_hz=3.0),
)


def flown(cell: Cell, seed: int, share: float) -> dict[float, tuple[float, float]]:
    """Return mean squared error, m², and NEES/2 of a flight by the share that is assumed."""
    made = drones_of(cell, seed, share)
    local = LocalMap(made["a"].flight.origin)
    configs = {name: config_of(cell, noise) for name, noise in zip(made, cell.noises, strict=True)}
    told = [
        (seen.pose.stamp_ns, name, seen)
        for name, one in made.items()
        for seen in own(one, configs[name])[1]
    ]
    told.sort(key=lambda item: item[:2])
    found = {}
    for assumed in SHARES:
        fleet = Fleet(configs, local, assumed)
        published = [fleet.update(name, seen).estimates for _, name, seen in told]
        found[assumed] = errors_at_end(made["a"], local, published)
    return found


def main() -> int:
    """Fly and print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--seeds", type=int, default=4, help="of each cell and share (default 4)")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    records: dict[tuple[float, float], list[tuple[float, float]]] = defaultdict(list)
    for number, cell in enumerate(CELLS):
        for k, share in enumerate(SHARES):
            for repeat in range(given.seeds):
                seed = 7_000_000 + 10_000 * number + 10 * repeat + k
                for assumed, errors in flown(cell, seed, share).items():
                    records[share, assumed].append(errors)
    rows = []
    for share in SHARES:
        of = [np.array(records[share, assumed]) for assumed in SHARES]
        rms = [f"{math.sqrt(float(one[:, 0].mean())):.3f}" for one in of]
        nees = [f"{float(one[:, 1].mean()):.2f}" for one in of]
        rows.append([f"{share:g}", *rms, *nees])
    heads = ["true share", "RMS, m: sure of 0", "expects 0.5", "sure of 1", "NEES/2: sure of 0",
             "expects 0.5", "sure of 1"]  # fmt: skip
    show(columns(heads, rows), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
