# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How far off is each method? Released code, paper, exact single image, ours, and the bound.

python benchmarks/accuracy.py --flights flights.jsonl --seeds 100 --markdown accuracy.md

Root mean square of the horizontal error over all robots with a box, each second from 10 s on, of
flights of 60 s with three robots; every method has the same boxes and telemetry, and all but ours
are given the data association. An error beyond 1 km counts as 1 km. The flights
are those of `consistency.py` and are kept in the same file (`flown.py`).
"""

from __future__ import annotations

import sys

from flown import Record, rms, write_table
from tables import columns


def row(cell: str, flights: list[Record]) -> list[str]:
    """Return one line of the table: RMS of each method, m, and ratios."""
    names = ("released", "paper", "single", "ours", "bound")
    found = {name: rms(flights, name) for name in names}
    ratios = [found[name] / found["ours"] for name in ("released", "paper", "single")]
    ratios.append(found["ours"] / found["bound"])
    return [cell, *(f"{value:.2f}" for value in (*found.values(), *ratios))]


def markdown(flights: dict[str, list[Record]]) -> str:
    """Return the table."""
    heads = [
        "flight", "released code m", "paper m", "exact single m", "ours m", "bound m",
        "released / ours", "paper / ours", "single / ours", "ours / bound",
    ]  # fmt: skip
    return columns(heads, [row(cell, one) for cell, one in flights.items()])


if __name__ == "__main__":
    sys.exit(write_table(str(__doc__).splitlines()[0], markdown))
