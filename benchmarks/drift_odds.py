# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What boxes tell of telemetry that drifts, of the drifts in `faults.py`.

python benchmarks/drift_odds.py --first 1 --seeds 2 --markdown drift_odds.md

Boxes of a drift are, to the last bit, those of robots that all swim with it. So what can be weighed
is only how their velocities changed. Each flight is flown with and without the drift; what the
corrections of a robot's velocity add up to differs between the two by exactly what the drift does.
`known`: logarithm of how much likelier these sums are, if the drift (which, since when, how fast)
were known exactly, than robots that changed their velocities themselves; the largest while it
lasts. No test can have more. `found`: the same for the best rotation of the camera, less what it
costs to choose it, which the program goes by: 3 are needed. `speed`: the fastest that the drift
makes a robot, m/s; robots may be as fast as `tracks.max_speed` (1.5 m/s).
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from unittest import mock

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from fault_cases import Case, cases
from fault_flights import FLIGHTS, Item, Run, flown
from fault_judge import judged, rows_of
from numpy.typing import NDArray
from tables import columns, show

from aerial_gnss_ros.core.faults import rotation_fault
from aerial_gnss_ros.core.faults.rotation_test import TUNING as ROTATION_TEST
from aerial_gnss_ros.core.faults.rotation_test import fit_rotation

Array = NDArray[np.float64]
Sums = dict[int, tuple[Array, Array, Array, float]]
"""By number of the judgement: sums, their variances, a swerve's sigma, gain of the best turn."""

HEADS = ["drift", "flight", "seed", "wrong", "speed, m/s", "known, nats", "found, nats"]


def judgements(case: Case, kind: str, seed: int, items: list[Item]) -> tuple[Sums, Run]:
    """Fly messages; return what was judged while the fault lasts, or would."""
    found: Sums = {}
    now = [0.0]
    flight = flown(kind, seed, case.aboard, case.sees)
    start_ns = flight.boxes[0].stamp_ns - round(float(flight.times[0]) * 1e9)

    def spy(
        sums: Array, variances: Array, by_angles: Array, swerve: Array
    ) -> tuple[Array, Array, float]:
        turn, spread, gain = fit_rotation(sums, variances, by_angles, swerve)
        if case.begin_s <= now[0] < case.end_s:
            found[round(10.0 * now[0])] = sums.copy(), variances.copy(), swerve, gain
        return turn, spread, gain

    run = Run(flight, case.stated | case.wrong)
    handle = run._handle  # noqa: SLF001 - to know what time it is

    def timed(item: Item) -> None:
        now[0] = (item.arrival_ns - start_ns) * 1e-9
        handle(item)

    with mock.patch.object(rotation_fault, "fit_rotation", spy), mock.patch.object(
        run, "_handle", timed
    ):  # fmt: skip
        run.fly(items)
    return found, run


def cost(sums: Array, variances: Array, swerve: Array) -> float:
    """Return the negative logarithm of the density of robots' own changes of velocity.

    As `rotation_test` has it: as stated, or a swerve, whichever is cheaper.
    """
    stated = np.maximum(variances, 1e-8)
    wide = stated + swerve**2
    squared = 0.5 * np.einsum("ij,ij->i", sums, sums)
    dear = np.log(wide / stated) - math.log(ROTATION_TEST.swerve_probability)
    return float(np.minimum(squared / stated, squared / wide + dear).sum())


def row(case: Case, kind: str, seed: int) -> list[str]:
    """Return the figures of one flight."""
    flight = flown(kind, seed, case.aboard, case.sees)
    usual, clean = judgements(case, kind, seed, list(flight.items))
    drifted, fault = judgements(case, kind, seed, case.items(flight, seed))
    known, best, speed = -math.inf, -math.inf, 0.0
    for when, (sums, variances, swerve, gain) in drifted.items():
        best = max(best, gain)
        if when in usual and usual[when][0].shape == sums.shape:
            without = usual[when][0]
            told = cost(sums, variances, swerve) - cost(without, variances, swerve)
            known = max(known, told)
            speed = max(speed, float(np.linalg.norm(sums - without, axis=1).max()))
    rows = [rows_of(flight, run.results) for run in (fault, clean)]
    verdict = judged(*rows, case.begin_s, case.end_s)
    return [
        case.words, kind, str(seed), str(verdict.wrong),
        f"{speed:.1f}", f"{known:.1f}", f"{best:.1f}",
    ]  # fmt: skip


def main() -> int:
    """Fly all drifts and print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--flights", default=",".join(FLIGHTS), help="kinds, comma between")
    parser.add_argument("--seeds", type=int, default=1, help="of each kind (default 1)")
    parser.add_argument("--first", type=int, default=1, help="the first one's seed (default 1)")
    parser.add_argument("--only", default="", help="drifts whose name begins so")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    drifts = [
        case
        for case in cases()
        if case.words.endswith("slow drift")
        and case.words.startswith(given.only)
        and not case.words.startswith("attitude: ")  # is not used
    ]
    rows = [
        row(case, kind, seed)
        for case in drifts
        for kind in given.flights.split(",")
        for seed in range(given.first, given.first + given.seeds)
    ]
    show(columns(HEADS, rows), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
