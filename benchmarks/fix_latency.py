# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What does a fix cost that is stamped late, with and without looking for its latency?

python benchmarks/fix_latency.py --flights 4 --markdown docs/results/latency.md

Simulated flights of 60 s, 30 m high, over three robots, of which one swims; an RTK receiver whose
positions are stamped late, default parameters. In `dji` a recorded DJI log is the drone's true
motion. Errors are of robots in view, each second from 10 s on, over a row's flights. `found`: mean
of the latencies that the estimator has found, and in how many flights it has. `wrong`: names that
end nearer to another robot than to their own.
"""

from __future__ import annotations

import argparse
import math
import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import one_thread  # noqa: F401 - before numpy

# isort: split
import families
import numpy as np
from families import results, truth
from tables import columns, show
from told_nothing import Cell, Record, World, score

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.values.rejection import Input
from aerial_gnss_ros.simulation.feeding import Sample, telemetry
from aerial_gnss_ros.simulation.sensors import Sensors

MOTIONS, LATE_S = ("transit", "orbit", "dji"), (0.0, 0.12, 0.3, -0.2)
SAID = re.compile(r"The fix is (\S+) s later than fix.latency_s")
HEADS = [
    "motion", "fix late by, s", "looked for", "RMS m", "published m", "NEES (2)", "positions",
    "wrong", "found s", "in flights",
]  # fmt: skip


def late_telemetry(sensors: Sensors, late_s: float) -> Iterator[tuple[Input, Sample]]:
    """Yield the telemetry with fixes that are stamped late."""
    for source, sample in telemetry(sensors):
        late_ns = round(late_s * 1e9) if source is Input.FIX else 0
        yield source, replace(sample, stamp_ns=sample.stamp_ns + late_ns)


def fly(motion: str, late_s: float, looks: bool, seed: int, log: Path) -> tuple[Record, float]:
    """Return a flight's sums (see `told_nothing.score`) and the latency found, s; NaN: none."""
    cell = Cell(motion, 30.0, "rtk", "mixed", 1.0, 300.0, 0.0, 15.0)
    world = World(cell, seed, log)
    images = list(world.made.detections())
    config = estimator_config(world.stated() | {"fix.find_latency": looks})
    engines: list[Estimator] = []
    with patch.object(families, "telemetry", lambda one: late_telemetry(one, late_s)):
        found = results(world.made, config, images, watch=lambda one, _: engines.append(one))
    true = truth(world.made, images)
    known = world.bounds(true, 0.0)
    told = [SAID.search(str(event)) for event in engines[-1].events]
    later_s = [float(one[1]) for one in told if one]
    return score(world, images, true, found, known, known), [*later_s, math.nan][0]


def row(motion: str, late_s: float, looks: bool, flights: int, log: Path) -> list[str]:
    """Return one line of the table."""
    total, found = defaultdict[str, float](float), []
    for seed in range(flights):
        record, later_s = fly(motion, late_s, looks, seed, log)
        found.append(later_s)
        for key in ("squares", "published", "nees", "samples", "wanted", "wrong"):
            total[key] += float(record[key])  # type: ignore[arg-type]
    n, known = total["samples"], np.isfinite(found)
    mean = f"{np.mean(np.array(found)[known]):.2f}" if known.any() else "–"
    return [
        motion, f"{late_s:g}", "yes" if looks else "no",
        f"{math.sqrt(total['squares'] / n / 2.0):.2f}",
        f"{math.sqrt(total['published'] / n / 2.0):.2f}", f"{total['nees'] / n:.2f}",
        f"{100.0 * n / total['wanted']:.0f} %", f"{total['wrong']:.0f}", mean,
        f"{known.sum()} of {flights}" if looks else "–",
    ]  # fmt: skip


def main() -> None:
    """Fly all rows and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--flights", type=int, default=4, help="of each row")
    parser.add_argument("--log", type=Path, default=Path("../shared/data/dji_tracking.csv"))
    parser.add_argument("--markdown", type=Path)
    given = parser.parse_args()
    rows = [
        row(motion, late_s, looks, given.flights, given.log)
        for motion in MOTIONS
        for late_s in LATE_S
        for looks in (False, True)
    ]
    show(columns(HEADS, rows), given.markdown)


if __name__ == "__main__":
    main()
