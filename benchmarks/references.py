# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What one thing of known position in view is worth, and what a wrong one does not do.

python benchmarks/references.py --flights references.jsonl --seeds 20 --markdown references.md

Flights of `families.py` with a consumer receiver: three robots and a beacon that stays. Its
surveyed place is wrong by as much as the stated sigma means on average (root mean square), in a
random direction, and each flight is flown again with the opposite error. So a few flights have the
mean square that the filter and the bound are told, and no correlation with the receiver's error.
RMS over the robots in view, each second from 10 s on; the bound is given the beacon's place as the
filter is. In `leaves`, the beacon has boxes in the first 20 s only, and counted is from 20 s on. In
`wrong`, its stated place is 5 m off. In `crowd`, the beacon is of the robots' class.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import ORIGIN, Cell, Image, Setting, bounds, config, experiment, results, robots_of
from families import truth as truth_of
from numpy.typing import NDArray
from tables import columns, show

from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.estimates import FrameResult, State
from aerial_gnss_ros.simulation.chance import generator
from aerial_gnss_ros.simulation.robot_models import AQUA

Array = NDArray[np.float64]
Record = dict[str, float | int | str]
FROM_S, LEAVES_S, WRONG_M = 10.0, 20.0, 5.0


@dataclass(frozen=True)
class Case:
    """One row.

    Attributes:
        family: hover, orbit or transit.
        moving: whether the robots swim.
        sigma_m: of the survey; 0: the beacon is not stated as a reference.
        kind: right, wrong, leaves or crowd.
    """

    family: str
    moving: bool
    sigma_m: float
    kind: str = "right"

    @property
    def words(self) -> str:
        """Return it in words."""
        robots = "moving" if self.moving else "still"
        known = f"{self.sigma_m:g} m" if self.sigma_m else "none"
        kind = "" if self.kind == "right" else f", {self.kind}"
        return f"{self.family} 30 m, {robots}, reference {known}{kind}"


CASES = [
    *(Case("orbit", moving, sigma) for moving in (False, True) for sigma in (0.0, 0.05, 0.2, 1.0)),
    *(Case("orbit", m, 0.05, kind) for kind in ("wrong", "leaves") for m in (False, True)),
    Case("orbit", True, 0.05, "crowd"),
    *(Case(family, m, s) for family in ("hover", "transit") for m in (False, True)
      for s in (0.0, 0.05)),
]  # fmt: skip


def fly(case: Case, seed: int) -> Record:
    """Return the sums over a seed's flights: two with opposite survey errors, if there are any."""
    course = generator(seed, "survey").uniform(-math.pi, math.pi)
    size = WRONG_M if case.kind == "wrong" else math.sqrt(2.0) * case.sigma_m
    off = size * np.array([math.cos(course), math.sin(course)])
    flights = [_fly(case, seed, sign * off) for sign in ((1.0, -1.0) if case.sigma_m else (1.0,))]
    total = {name: sum(one[name] for one in flights) for name in flights[0]}
    return {"case": case.words, "seed": seed, "flights": len(flights), **total}


def _fly(case: Case, seed: int, off: Array) -> dict[str, float]:
    """Return the figures of one flight, its survey being off by (2,), m East and North."""
    cell, setting = Cell(case.family, 30.0, "consumer", case.moving), Setting(robots=4, beacons=1)
    made = experiment(cell, seed, setting)
    crowd = case.kind == "crowd"
    stated: dict[str, object] = {}
    if not crowd:
        stated = {"classes.beacon.max_speed": 0.01, "classes.beacon.acceleration": 0.0}
    place = made.swarm.positions([0.0])[0, :, :2]
    latitude, longitude = LocalMap(ORIGIN).places(place + off)
    known = {}
    if case.sigma_m:
        degrees = [math.degrees(latitude[0]), math.degrees(longitude[0])]
        stated |= {f"references.pier.{key}": value for key, value in (
            ("class", AQUA if crowd else "beacon"), ("position", degrees),
            ("sigma_m", case.sigma_m))}  # fmt: skip
        known = {0: case.sigma_m}
    parameters = config(cell, replace(setting, stated=stated))
    images = list(made.detections())
    if case.kind == "leaves":
        images = [_without(image) if image[0].t > LEAVES_S else image for image in images]
    if crowd:
        images = [_alike(image) for image in images]
    engines: list[Estimator] = []

    def watch(engine: Estimator, _results: list[FrameResult]) -> None:
        engines[:] = [engine]

    found = results(made, parameters, images, watch=watch)
    true = truth_of(made, images)
    if case.kind == "leaves":
        seen = [image[0].t <= LEAVES_S for image in images]
        true = [
            replace(one, seen=one.seen & np.array([there, True, True, True]))
            for one, there in zip(true, seen, strict=True)
        ]
    limits = bounds(made, parameters, true, None if case.kind == "wrong" else known)
    names = robots_of(found, true)
    said = " ".join(str(one) for one in engines[0].events)
    sums = dict.fromkeys(("squares", "bound", "published", "nees"), 0.0)
    samples = 0
    for k, result in enumerate(found):
        t = round((true[k].pose.stamp_ns - true[0].pose.stamp_ns) * 1e-9, 3)
        if t < (LEAVES_S if case.kind == "leaves" else FROM_S) or abs(t - round(t)) > 1e-6:
            continue
        for estimate in result.estimates:
            robot = names[estimate.robot_id]
            if robot == 0 or estimate.state is not State.CONFIRMED or not true[k].seen[robot]:
                continue
            error = estimate.position - true[k].positions[robot]
            covariance = estimate.covariance[:2, :2]
            samples += 1
            sums["squares"] += float(error @ error)
            sums["nees"] += float(error @ np.linalg.solve(covariance, error))
            sums["published"] += float(np.trace(covariance))
            sums["bound"] += float(np.trace(limits[k, robot, :2, :2]))
    return {
        "samples": samples, **sums,
        "used": int("positions refer to it" in said), "refused": int("is not used" in said),
    }  # fmt: skip


def _without(image: Image) -> Image:
    """Return an image whose beacon the detector misses."""
    frame, boxes, found = image
    kept = [i for i, name in enumerate(found.class_ids) if name != "beacon"]
    return frame, boxes, found.rows(kept)


def _alike(image: Image) -> Image:
    """Return an image in which the detector takes the beacon for one of the robots."""
    frame, boxes, found = image
    return frame, boxes, replace(found, class_ids=(AQUA,) * len(found.class_ids))


def row(words: str, flights: list[Record]) -> list[str]:
    """Return one line of the table."""
    total = {
        name: sum(float(one[name]) for one in flights)
        for name in (
            "flights",
            "samples",
            "squares",
            "bound",
            "published",
            "nees",
            "used",
            "refused",
        )
    }
    ours, limit, told = (
        math.sqrt(total[name] / total["samples"]) for name in ("squares", "bound", "published")
    )
    return [
        words, f"{ours:.2f}", f"{limit:.2f}", f"{ours / limit:.2f}", f"{told / ours:.2f}",
        f"{total['nees'] / total['samples']:.2f}", f"{total['flights']:.0f}",
        f"{total['used']:.0f}", f"{total['refused']:.0f}",
    ]  # fmt: skip


def markdown(flights: dict[str, list[Record]]) -> str:
    """Return the table."""
    heads = ["flight", "RMS m", "bound m", "RMS / bound", "published / RMS", "NEES (2)",
             "flights", "used", "refused"]  # fmt: skip
    return columns(heads, [row(words, one) for words, one in flights.items() if one])


def main() -> int:
    """Fly what lacks and print the table; return the exit status."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--flights", type=Path, required=True, help="JSON lines; goes on there")
    parser.add_argument("--seeds", type=int, default=20, help="of flights a row (default 20)")
    parser.add_argument("--first", type=int, default=0, help="the first one's seed (default 0)")
    parser.add_argument("--minutes", type=float, default=math.inf, help="begin no flight later")
    parser.add_argument("--only", default="", help="rows whose words hold this")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    done: dict[tuple[str, int], Record] = {}
    if given.flights.exists():
        for line in given.flights.read_text(encoding="utf-8").splitlines():
            one = json.loads(line)
            done[one["case"], one["seed"]] = one
    until, cases = time.monotonic() + 60.0 * given.minutes, CASES
    cases = [case for case in CASES if given.only in case.words]
    seeds = range(given.first, given.first + given.seeds)
    for seed in seeds:
        for case in cases:
            if (case.words, seed) in done or time.monotonic() > until:
                continue
            record = done[case.words, seed] = fly(case, seed)
            with given.flights.open("a", encoding="utf-8") as file:
                file.write(json.dumps(record) + "\n")
    whole = [seed for seed in seeds if all((case.words, seed) in done for case in cases)]
    if not whole:
        print("No seed has been flown in all of these rows yet.", file=sys.stderr)
        return 1
    table = markdown({case.words: [done[case.words, seed] for seed in whole] for case in cases})
    show(f"Seeds: {len(whole)}\n\n{table}", given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
