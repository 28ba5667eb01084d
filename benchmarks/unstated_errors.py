# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recorded flights with one input made wrong, replayed with default parameters.

python benchmarks/unstated_errors.py --markdown docs/results/unstated_errors.md

A flight is a bag NAME with boxes on the canonical topics beside NAME.truth.json, which has the
robots' places at each image (`stamp_ns`, `lat`, `lon`, `seen`). Messages are changed as they are
read. Of the last third: confirmed positions by the robots in view, root mean square of their errors
and of what is published, and half the mean of the errors squared and normalised (NEES/2; medians
over flights), the share of all whose squared distance from the nearest robot is above 13.8 (one in
a thousand of a right covariance), the names of all flights; then that share, and the error, of each
flight. `--only` chooses cases.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from tables import columns, show
from turned import CONFIDENT
from wrong_inputs import CASES, Change

from aerial_gnss_ros.bags.reader import BagReader, open_bag
from aerial_gnss_ros.bags.replay import Replay, no_detector
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.estimates import MapDatum, State
from aerial_gnss_ros.detection.config import DetectorConfig


class Wrong:
    """A bag whose messages on one topic are changed as they are read."""

    def __init__(self, bag: BagReader, topic: str, change: Change) -> None:
        self._bag, self._topic, self._change = bag, topic, change

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bag, name)

    def messages(self, topics: Sequence[str]) -> Iterator[Any]:
        """Yield the messages of the bag."""
        begin: int | None = None
        for recorded in self._bag.messages(topics):
            begin = recorded.log_ns if begin is None else begin
            if recorded.topic != self._topic:
                yield recorded
                continue
            message = recorded.message()
            if not self._change(message, 1e-9 * (recorded.log_ns - begin)):
                yield Changed(recorded, message)


class Changed:
    """A recorded message with another content."""

    def __init__(self, recorded: Any, message: Any) -> None:
        self._recorded, self._message = recorded, message

    def __getattr__(self, name: str) -> Any:
        return getattr(self._recorded, name)

    def message(self) -> Any:
        """Return the content."""
        return self._message


@dataclass(frozen=True)
class Figures:
    """What became of a flight's last third.

    Attributes:
        case: what was wrong.
        flight: its name.
        positions: confirmed ones, by the robots in view.
        wrong: the share of these that are wrong and confident.
        error_m: root mean square of their distance.
        sigma_m: root mean square of what is published.
        nees: normalised estimation error squared, the mean by its expectation, 2.
        names: how many of them had positions.
    """

    case: str
    flight: str
    positions: float
    wrong: float
    error_m: float
    sigma_m: float
    nees: float
    names: int


def fly(case: str, path: Path) -> Figures:
    """Replay a flight with one input wrong."""
    truth = json.loads(path.with_name(f"{path.name}.truth.json").read_text())
    image_of = {stamp: i for i, stamp in enumerate(truth["stamp_ns"])}
    lat, lon = np.radians(truth["lat"]), np.radians(truth["lon"])
    seen = np.array(truth["seen"])
    local = LocalMap(MapDatum(lat[0, 0], lon[0, 0], 0.0))
    first = 2 * len(seen) // 3
    found, names = [], set()
    with open_bag([path]) as bag:
        wrong = Wrong(bag, *CASES[case])
        for result in Replay(wrong, estimator_config({}), DetectorConfig(), no_detector).results():
            image = image_of.get(result.stamp_ns, -1)
            if image < first:
                continue
            robots = local.positions(lat[image], lon[image])[:, :2]
            for one in result.estimates:
                if one.state is not State.CONFIRMED:
                    continue
                place = local.positions(np.array([one.latitude]), np.array([one.longitude]))[0, :2]
                off = robots - place
                off = off[np.argmin(np.hypot(*off.T))]
                spread = one.covariance[:2, :2]
                found.append((off @ off, np.trace(spread), off @ np.linalg.solve(spread, off)))
                names.add(one.robot_id)
    squared, spread, odd = np.array(found).reshape(-1, 3).T
    return Figures(
        case, path.name, len(found) / max(int(seen[first:].sum()), 1),
        float(np.mean(odd > CONFIDENT)) if found else math.nan,
        *(math.sqrt(one.mean()) if found else math.nan for one in (squared, spread)),
        0.5 * float(odd.mean()) if found else math.nan, len(names),
    )  # fmt: skip


def table(every: Sequence[Figures], flights: Sequence[str]) -> str:
    """Return a row for each case: all flights, and the share of each that is wrong."""
    rows = []
    for case in dict.fromkeys(one.case for one in every):
        of_case = {one.flight: one for one in every if one.case == case}
        weights = np.array([one.positions for one in of_case.values()])
        middle = [
            f"{np.nanmedian([getattr(one, name) for one in of_case.values()]):.2f}"
            for name in ("positions", "error_m", "sigma_m", "nees")
        ]
        wrong = np.nansum(weights * [one.wrong for one in of_case.values()]) / weights.sum()
        names = sum(one.names for one in of_case.values())
        each = [
            f"{100 * of_case[name].wrong:.0f} ({of_case[name].error_m:.2f} m)" for name in flights
        ]
        rows.append([case, *middle, f"{100 * wrong:.1f}", str(names), *each])
    heads = ["wrong", "positions", "error m", "sigma m", "NEES/2", "outside %", "names"]
    return columns(heads + list(flights), rows)


def main() -> None:
    """Fly, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    folder = Path("../shared/data/independent_flights")
    parser.add_argument("--flights", type=Path, default=folder, help="folder of the flights")
    parser.add_argument("--only", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--markdown", type=Path, metavar="FILE")
    args = parser.parse_args()
    flights = sorted(one for one in args.flights.iterdir() if one.is_dir())
    runs = list(product(args.only, flights))
    with ProcessPoolExecutor(args.processes) as pool:
        every = list(pool.map(fly, *zip(*runs, strict=True)))
    show(table(every, [path.name for path in flights]), args.markdown)


if __name__ == "__main__":
    main()
