# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Are positions as good as physics allows, and is their covariance honest? A table over families.

python benchmarks/consistency.py --flights flights.jsonl --seeds 100 --markdown consistency.md

NEES is e' P^-1 e of a robot's East and North at 10, 30 and 60 s, of robots in view; its expectation
is 2. Robots of one flight share the platform's errors, so the chi-square band is that of one robot
a flight (the seed says which), at 95 % over all cells and times together (Bonferroni); the mean
printed is of the same robots. RMS and bound are over all robots with a box, each second from 10 s
on. The flights are kept in a file and may be flown in several runs (`flown.py`).
"""

from __future__ import annotations

import sys

import numpy as np
from flown import TIMES_S, Record, rms, write_table
from scipy.stats import chi2
from tables import columns


def band(count: int, tests: int) -> tuple[float, float]:
    """Return the limits of the mean of planar NEES that one of `tests` leaves at 5 % in all."""
    tail = 0.05 / tests / 2.0
    return (
        float(chi2.ppf(tail, 2 * count)) / count,
        float(chi2.ppf(1.0 - tail, 2 * count)) / count,
    )


def row(cell: str, flights: list[Record], tests: int) -> list[str]:
    """Return one line of the table."""
    means, outside = [], []
    for t in TIMES_S:
        values = [one["nees"][f"{t:g}"] for one in flights if f"{t:g}" in one["nees"]]  # type: ignore[index,operator]
        mean = float(np.mean(values)) if values else float("nan")
        low, high = band(len(values), tests) if values else (0.0, 0.0)
        means.append(f"{mean:.2f} ({len(values)})" if values else "–")
        outside += ["low" if mean < low else "HIGH"] if values and not low <= mean <= high else []
    every = [value for one in flights for value in one["nees_all"]]  # type: ignore[attr-defined]
    ours, limit, told = (rms(flights, name) for name in ("ours", "bound", "published"))
    return [
        cell, *means, f"{np.mean(every):.2f}" if every else "–", " ".join(outside) or "yes",
        f"{ours:.3f}", f"{limit:.3f}", f"{ours / limit:.2f}", f"{told / limit:.2f}",
        str(sum(one["extra_names"] for one in flights)),  # type: ignore[misc]
    ]  # fmt: skip


def markdown(flights: dict[str, list[Record]]) -> str:
    """Return the table."""
    heads = [
        "flight", *(f"NEES {t:g} s (flights)" for t in TIMES_S), "all robots", "in band", "RMS m",
        "bound m", "RMS / bound", "published / bound", "extra names",
    ]  # fmt: skip
    tests = len(TIMES_S) * len(flights)
    return columns(heads, [row(cell, one, tests) for cell, one in flights.items()])


if __name__ == "__main__":
    sys.exit(write_table(str(__doc__).splitlines()[0], markdown))
