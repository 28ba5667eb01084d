# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulated robots under a recorded drone: names, and errors as large as stated?

python benchmarks/recorded.py --seeds 3,4,5,6 --markdown recorded.md

Path, attitude and gimbal are those of a DJI log; sensors' errors, robots and boxes are simulated as
by `aerial-gnss simulate --telemetry`: three robots that steer, 20 % missed, 0.15 false boxes an
image. All is consumer grade but the receiver, unless `--consumer` is given: the 1.2 m offset of a
consumer receiver cannot be seen, and one draw of it a flight would be all that the errors show.
Errors are those of robots in sight against the robot that a name belongs to. All robots of a flight
share the platform's errors: the mean NEES of a flight scatters by about as much as it is (2).
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import RTK_OFFSET_M
from identity import named
from tables import show

from aerial_gnss_ros.adapters.dji_log import DjiLog, read_dji_log
from aerial_gnss_ros.simulation.boxes import DetectorPlan
from aerial_gnss_ros.simulation.experiment import Experiment, default_camera
from aerial_gnss_ros.simulation.recorded import RecordedFlight
from aerial_gnss_ros.simulation.sensors import sensor_plan

PIECES = ((480.0, 300.0), (100.0, 120.0), (700.0, 120.0))
"""Start and length of the pieces flown, s."""

HEADS = (
    "from s", "for s", "flights", "robots", "names", "switches", "IDF1", "wrong names", "unsaid",
    "NEES", "RMS m", "published m",
)  # fmt: skip


def fly(log: DjiLog, piece: tuple[float, float], seed: int, consumer: bool) -> np.ndarray:
    """Return robots, names, switches, IDF1, wrong names, unsaid, NEES, mean squares of a flight."""
    offset = {} if consumer else {"gnss_offset_m": RTK_OFFSET_M}
    made = Experiment(
        RecordedFlight(log, *piece), default_camera(1280, 720), sensor_plan("consumer", **offset),
        detector=DetectorPlan(2.0, 0.2, 0.15), seed=seed,
    )  # fmt: skip
    stated = {f"noise.{name}": value for name, value in offset.items()}
    scores, owners, counts = named(made, stated)
    if scores is None:
        raise SystemExit("identity scores need the extra [identity].")
    robots = len(made.swarm.names)
    return np.array(
        [
            robots, robots + counts["new_names"], scores.switches, scores.idf1,
            counts["wrong_names"], counts["unsaid"], *np.mean(owners.errors, axis=0),
        ]
    )  # fmt: skip


def row(piece: tuple[float, float], flights: np.ndarray) -> str:
    """Return one line of the table: sums of counts, means over flights, roots of mean squares."""
    robots, names, switches, _, wrong, unsaid = flights.sum(axis=0)[:6]
    mean = flights.mean(axis=0)
    cells = [f"{piece[0]:g}", f"{piece[1]:g}", str(len(flights))]
    cells += [f"{robots:.0f}", f"{names:.0f}", f"{switches:.0f}", f"{mean[3]:.3f}", f"{wrong:.0f}"]
    cells += [f"{unsaid:.0f}", f"{mean[6]:.2f}", f"{mean[7] ** 0.5:.2f}", f"{mean[8] ** 0.5:.2f}"]
    return f"| {' | '.join(cells)} |"


def main() -> int:
    """Fly all pieces and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--log", type=Path, default=Path("../shared/data/dji_tracking.csv"))
    parser.add_argument("--seeds", default="3,4,5,6", help="comma between (default 3,4,5,6)")
    parser.add_argument("--consumer", action="store_true", help="a receiver with a 1.2 m offset")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    log, seeds = read_dji_log(given.log), [int(one) for one in given.seeds.split(",")]
    lines = [f"| {' | '.join(HEADS)} |", "|" + "---:|" * len(HEADS)]
    for piece in PIECES:
        flights = np.array([fly(log, piece, seed, given.consumer) for seed in seeds])
        lines.append(row(piece, flights))
        print(lines[-1], file=sys.stderr, flush=True)
    table = "\n".join(lines) + "\n"
    show(table, given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
