# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What each remedy against spurious information is worth: docs/results/consistency.md.

python benchmarks/plain_filter.py --seeds 6

The same flights three times: as the filter is; without carrying the covariance along with robots
that move (each image's derivative is taken where the robot is just then, as a plain extended filter
does); and with the camera's place as this image measures it, not as earlier ones foretell it. NEES
is expected to be 2; published / bound below 1 claims what is not there.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import Setting
from flown import Record, chosen, fly, rms
from tables import columns, show

from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.state import JointState

HARD = "hover,rtk,moving"
"""Cells in which little can be known of height and tilt, and nothing else hides what is claimed."""

_of = CameraView.of


def _nothing(*_: Any) -> None:
    """Leave the covariance as it is."""


def _as_measured(camera: Any, measured: Any, rates: Any, applied: float, *rest: Any) -> CameraView:
    return _of(camera, measured, rates, applied, None, *rest[1:])


@contextmanager
def without(*parts: tuple[type, str, Callable[..., Any]]) -> Iterator[None]:
    """Put others in the place of parts of the filter."""
    with ExitStack() as stack:
        for owner, name, other in parts:
            stack.enter_context(patch.object(owner, name, other))
        yield


VARIANTS = {
    "as it is": (),
    "not carried": ((JointState, "carry", _nothing),),
    "not foretold": ((CameraView, "of", staticmethod(_as_measured)),),
}


def row(cell: str, flights: dict[str, list[Record]]) -> list[str]:
    """Return one line of the table."""
    cells = [cell]
    for found in flights.values():
        every = [value for one in found for value in one["nees_all"]]  # type: ignore[attr-defined]
        told, ours, limit = (rms(found, name) for name in ("published", "ours", "bound"))
        cells += [f"{np.mean(every):.2f}", f"{told / limit:.2f}", f"{ours / limit:.2f}"]
    return cells


def main() -> int:
    """Fly and print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--seeds", type=int, default=6, help="flights a cell (default 6)")
    parser.add_argument("--only", default=HARD, help=f"as for consistency.py (default {HARD})")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    rows = []
    for cell in chosen(given.only):
        flights: dict[str, list[Record]] = {}
        for name, parts in VARIANTS.items():
            with without(*parts):
                flights[name] = [fly(cell, seed, Setting()) for seed in range(given.seeds)]
        rows.append(row(cell.words, flights))
        print(rows[-1], file=sys.stderr, flush=True)
    heads = [f"{name}: {what}" for name in VARIANTS for what in
             ("NEES", "published / bound", "RMS / bound")]  # fmt: skip
    show(columns(["flight", *heads], rows), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
