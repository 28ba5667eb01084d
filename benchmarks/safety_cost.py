# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the protection against failures and faults costs an image, part by part.

python benchmarks/safety_cost.py --markdown docs/results/scaling.md

Each part is left out in turn, and all of them together; the flights of scaling.py have no fault, so
positions are the same but for centimetres. Programs are compared within one run, flight by flight
in turns; a cell is the median over rounds. A part's share holds also what it displaces from the
processor's cache.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from scaling import measure
from tables import show

from aerial_gnss_ros.core.estimation import guard
from aerial_gnss_ros.core.faults.frozen_input import FrozenInputDetector
from aerial_gnss_ros.core.tracker.track_table import TrackTable
from aerial_gnss_ros.core.tracker.tracker import Tracker


def _nothing(*_: object) -> None:
    """Stand in for a part that is left out."""


def _not(*_: object) -> bool:
    """Stand in for a test of a fault."""
    return False


PARTS: dict[str, tuple[tuple[object, str, object], ...]] = {
    "snapshot": ((guard, "Snapshot", _nothing),),
    "checks of state": ((guard, "check_estimates", _nothing), (Tracker, "check", _nothing)),
    "noise level": ((TrackTable, "note_innovations", _nothing),),
    "frozen inputs": (
        (FrozenInputDetector, "telemetry_frozen", _not),
        (FrozenInputDetector, "image_frozen", _not),
    ),
}
"""Parts by name: owner, attribute and what stands in for it."""
COUNTS = (3, 30, 100)


@contextmanager
def left_out(names: tuple[str, ...]) -> Iterator[None]:
    """Leave out some parts."""
    patches = [patch.object(*one) for name in names for one in PARTS[name]]
    for one in patches:
        one.start()
    try:
        yield
    finally:
        for one in patches:
            one.stop()


def row(robots: int, images: int, rounds: int) -> str:
    """Return a row of the table: an image's time, and the share of each part and of all."""
    choices: list[tuple[str, ...]] = [(), *((name,) for name in PARTS), tuple(PARTS)]
    times = np.empty((rounds, len(choices)))
    for i in range(rounds):
        for k, names in enumerate(choices):
            with left_out(names):
                times[i, k] = measure(robots, images)["median_us"]
    shares = np.median(1.0 - times[:, 1:] / times[:, :1], axis=0)
    cells = " | ".join(f"{share:.0%}" for share in shares)
    return f"| {robots} | {np.median(times[:, 0]):.0f} | {cells} |"


def table(images: int, rounds: int) -> str:
    """Return the table."""
    heads = " | ".join(["robots", "µs an image", *PARTS, "all of these"])
    rows = [row(robots, images, rounds) for robots in COUNTS]
    return "\n".join([f"| {heads} |", "|---:" * (len(PARTS) + 3) + "|", *rows]) + "\n"


def main() -> int:
    """Measure and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--images", type=int, default=300, help="of each flight (default 300)")
    parser.add_argument("--rounds", type=int, default=5, help="default 5")
    parser.add_argument("--markdown", type=Path)
    given = parser.parse_args()
    show(table(given.images, given.rounds), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
