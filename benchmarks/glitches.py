# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Telemetry that is wrong for a moment: are robots lost, and for how long are they in doubt?

python benchmarks/glitches.py --markdown glitches.md

At 20 s the gimbal's telemetry turns at once by so many degrees about one axis, and turns back at
once after so long; the camera does not turn. Robots and sensors are else as stated, the receiver is
RTK. Each flight is flown without that too. Above a squared distance of 13.8 (one in a thousand of a
right covariance) a position counts as wrong and confident. `sigma` is the median, over robots in
view from 3 s after the end on, of what is published by what is published without it; `worst` its
95th percentile. `positions`: measured ones from the end on, by those without it.
"""

from __future__ import annotations

import itertools
import math
import sys
from dataclasses import dataclass

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import Cell, Setting, config, experiment, results, robots_of, truth
from numpy.typing import NDArray
from tables import columns, show
from turned import CONFIDENT, STATED, Turned, arguments, cell_of, errors, tell

from aerial_gnss_ros.core.values.estimates import FrameResult, State
from aerial_gnss_ros.simulation.experiment import Experiment

Array = NDArray[np.float64]

BEGIN_S, SETTLED_S, AFTER_S = 20.0, 3.0, 15.0


@dataclass(frozen=True)
class Case:
    """One flight.

    Attributes:
        cell: family, height, and whether robots move.
        robots: how many.
        axis: about which telemetry turns.
        angle_deg: by how much.
        seed: of all chance.
    """

    cell: Cell
    robots: int
    axis: str
    angle_deg: float
    seed: int

    def made(self, seconds: float, lasts_s: float) -> Experiment:
        """Return the flight, so long, with a moment of wrong telemetry so long."""
        made = experiment(self.cell, self.seed, Setting(self.robots, lasts_s))
        if seconds:
            angle = math.radians(self.angle_deg)
            turned = Turned(
                made.flight, self.axis,
                lambda t: angle * ((t > BEGIN_S - 0.05) & (t < BEGIN_S - 0.05 + seconds)),
            )  # fmt: skip
            tell(made, turned, self.seed)
        return made


@dataclass(frozen=True)
class Flown:
    """What became of a flight.

    Attributes:
        samples: (k, 5) of measured positions: time s, robot, error m, sigma m, squared distance.
        names: how many beyond the robots.
        moved: names that are on another robot at the end than before the moment.
    """

    samples: Array
    names: int
    moved: int


def flown(case: Case, seconds: float, lasts_s: float) -> Flown:
    """Fly one."""
    made = case.made(seconds, lasts_s)
    images = list(made.detections())
    true = truth(made, images)
    found = results(made, config(case.cell, Setting(stated=dict(STATED))), images)
    times = [image.t for image, _, _ in images]
    early = sum(t < BEGIN_S - 0.1 for t in times)
    late = next(i for i, t in enumerate(times) if t > lasts_s - 2.0)
    own = robots_of(found[:early], true[:early])
    now = robots_of(found[late:], true[late:])
    rows = [
        (t, *one)
        for result, frame, t in zip(found, true, times, strict=True)
        if t >= BEGIN_S - 0.1
        for one in errors(result, frame, own)
        if frame.seen[one[0]]
    ]
    return Flown(
        np.array(rows).reshape(-1, 5),
        len({e.robot_id for r in found for e in r.estimates}) - case.robots,
        sum(own[name] != now[name] for name in own if name in now and worn(found[late:], name)),
    )


def worn(found: list[FrameResult], name: str) -> bool:
    """Return whether a robot in view wears a name."""
    return any(
        e.robot_id == name and e.state is State.CONFIRMED for r in found for e in r.estimates
    )


def row(robots: int, seconds: float, flights: list[tuple[Flown, Flown]]) -> list[str]:
    """Return one line of the table, of flights with and without the moment."""
    every = np.concatenate([one.samples for one, _ in flights])
    confident = every[:, 4] > CONFIDENT
    end = BEGIN_S + seconds
    ratios: list[float] = []
    count = [0, 0]
    for one, other in flights:
        known = {(t, r): sigma for t, r, _, sigma, _ in other.samples.tolist()}
        for k, flight in enumerate((one, other)):
            count[k] += int((flight.samples[:, 0] >= end).sum())
        ratios += [
            sigma / known[t, r]
            for t, r, _, sigma, _ in one.samples.tolist()
            if t >= end + SETTLED_S and (t, r) in known
        ]
    middle, most = np.percentile(ratios, [50, 95]) if ratios else (math.nan, math.nan)
    return [
        str(robots), f"{seconds:g}", str(len(flights)), f"{100.0 * confident.mean():.1f} %",
        f"{every[confident, 2].max():.1f}" if confident.any() else "–",
        f"{middle:.2f}", f"{most:.2f}",
        f"{count[0] / max(1, count[1]):.0%}", str(sum(one.names for one, _ in flights)),
        str(sum(one.moved for one, _ in flights)),
    ]  # fmt: skip


HEADS = (
    "robots", "wrong for s", "flights", "wrong and confident", "worst of these m", "sigma",
    "worst", "positions", "extra names", "names on other robots",
)  # fmt: skip


def main() -> int:
    """Fly and print the table."""
    parser = arguments(str(__doc__), "1,2,4", "hover 30,orbit 30,orbit 10", "yaw,pitch")
    parser.add_argument("--seconds", default="0.1,0.3,1,3,10", help="how long it is wrong")
    parser.add_argument("--angles", default="5,30", help="by how many degrees")
    given = parser.parse_args()
    seconds = [float(one) for one in given.seconds.split(",")]
    lasts_s, rows = BEGIN_S + max(seconds) + AFTER_S, []
    kinds = list(itertools.product(
        given.flights.split(","), given.motion.split(","), given.axes.split(","),
        given.angles.split(","), range(given.seeds),
    ))  # fmt: skip
    for number in given.robots.split(","):
        cases = [
            Case(cell_of(one, motion), int(number), axis, float(angle), given.first_seed + seed)
            for seed, (one, motion, axis, angle, _) in enumerate(kinds)
        ]  # fmt: skip
        usual = [flown(case, 0.0, lasts_s) for case in cases]
        for wrong_s in seconds:
            found = [flown(case, wrong_s, lasts_s) for case in cases]
            rows.append(row(int(number), wrong_s, list(zip(found, usual, strict=True))))
            print(" | ".join(rows[-1]), file=sys.stderr, flush=True)
    show(columns(list(HEADS), rows), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
