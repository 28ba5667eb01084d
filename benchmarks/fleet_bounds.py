# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much better two drones with RTK can be than one, by the bound of all boxes.

python benchmarks/fleet_bounds.py --markdown docs/results/fleet.md

No filter runs: the bound says what the measurements contain.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path

import numpy as np
from fleet_flights import LAST_S, RTK, Cell, config_of, drones_of, trace, true_drone
from tables import columns, show

from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.evaluation.bound import bound, joint_bound

HEADS = ["height, m", "robots", "spread / height", "alone, m", "both, m", "gain"]
SEEDS = (701, 702)


def row(height_m: float, robots: int, seed: int) -> list[str]:
    """Return the bounds of a hover over robots that stay, which the filter knows."""
    cell = Cell("hover", "opposite", height_m, RTK, told=True, robots=robots, duration_s=30.0)
    made = drones_of(cell, seed, 0.5)
    first, local = made["a"], LocalMap(made["a"].flight.origin)
    drones = [true_drone(one, config_of(cell, "rtk")) for one in made.values()]
    end = round(LAST_S * first.clock.rate_hz)
    both = math.sqrt(trace(joint_bound(drones, local, 0.5)[0][-end:]))
    own = bound(drones[0].config, drones[0].camera, drones[0].frames, local)
    alone = math.sqrt(trace(own[-end:]))
    spread = math.sqrt(float(np.sum(first.swarm.positions([0.0])[:, 0, :2].var(axis=0))))
    return [
        f"{height_m:g}", str(robots), f"{spread / height_m:.2f}", f"{alone:.3f}", f"{both:.3f}",
        f"{alone / both:.2f}",
    ]  # fmt: skip


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    rows = [
        row(height_m, robots, seed)
        for height_m in (10.0, 30.0, 80.0)
        for robots in (3, 1)
        for seed in SEEDS
    ]
    show(columns(HEADS, rows), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
