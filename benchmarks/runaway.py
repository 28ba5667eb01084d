# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A gimbal that turns by itself: positions and warnings. See docs/results/telemetry_faults.md.

python benchmarks/runaway.py --markdown runaway.md

From 20 s on telemetry turns by itself for 10 s, about one axis, stays turned for 10 s, turns back
as fast, and is right again; the camera does not turn (`--camera`: the camera turns so, and
telemetry does not report it). Robots and sensors are else as stated; the receiver is RTK, the
robots' acceleration and greatest speed are the defaults. NEES is e' P^-1 e of a robot's East and
North; above 13.8 (one in a thousand of a right covariance) the position counts as wrong and
confident. A row is of hovers and orbits, still and moving robots, and all three axes, each flight
of a seed of its own. Errors are of robots in sight.
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

from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.simulation.experiment import Experiment
from aerial_gnss_ros.simulation.sensors import START_NS

Array = NDArray[np.float64]

BEGIN_S, RUN_S, STAY_S, SETTLE_S = 20.0, 10.0, 10.0, 10.0
END_S = BEGIN_S + 2.0 * RUN_S + STAY_S + SETTLE_S


def seconds_turned(t: Array) -> Array:
    """Return for how long (n,) it has turned, less for how long it has turned back, s."""
    back = BEGIN_S + RUN_S + STAY_S
    return np.asarray(np.clip(t - BEGIN_S, 0.0, RUN_S) - np.clip(t - back, 0.0, RUN_S))


@dataclass
class Case:
    """One flight.

    Attributes:
        cell: family, height, and whether robots move.
        robots: how many.
        axis: about which it turns.
        rate_deg_s: how fast.
        camera: whether the camera turns unnoticed by telemetry.
    """

    cell: Cell
    robots: int
    axis: str
    rate_deg_s: float
    camera: bool = False

    def made(self, seed: int) -> Experiment:
        """Return the flight."""
        made = experiment(self.cell, seed, Setting(self.robots, END_S))
        rate = math.radians(self.rate_deg_s)
        turned = Turned(made.flight, self.axis, lambda t: rate * seconds_turned(t))
        if self.camera:
            made.flight = turned
        else:
            tell(made, turned, seed)
        return made


PHASES = (BEGIN_S, BEGIN_S + RUN_S, BEGIN_S + RUN_S + STAY_S, END_S - SETTLE_S, END_S)


def flown(case: Case, seed: int) -> dict[str, object]:
    """Return what became of one flight: samples (k, 4) of time, error, sigma, NEES; words."""
    made = case.made(seed)
    stated = config(case.cell, Setting(stated=dict(STATED)))
    images = list(made.detections())
    true = truth(made, images)
    said: list[tuple[float, tuple[str, ...]]] = []

    def listen(engine: Estimator, new: list[FrameResult]) -> None:
        said.append(((new[-1].stamp_ns - START_NS) * 1e-9, engine.health.complaints))

    found = results(made, stated, images, watch=listen)
    early = [r for r, image in zip(found, images, strict=True) if image[0].t < BEGIN_S]
    names = robots_of(early, true[: len(early)])
    samples, images_of = [], 0
    for result, frame, (image, _, _) in zip(found, true, images, strict=True):
        if image.t < BEGIN_S:
            continue
        images_of += int(frame.seen.sum())
        samples += [(image.t, *one[1:]) for one in errors(result, frame, names)]
    begin = next((t - BEGIN_S for t, words in said if t >= BEGIN_S and words), math.nan)
    early_words = {w for t, words in said if t < BEGIN_S for w in words}
    return {
        "samples": np.array(samples).reshape(-1, 4), "seen": images_of, "said": begin,
        "early": early_words, "words": {w for _, words in said for w in words},
        "names": len({e.robot_id for r in found for e in r.estimates}) - case.robots,
    }  # fmt: skip


def row(robots: int, rate_deg_s: float, flights: list[dict[str, object]]) -> list[str]:
    """Return one line of the table: of all flights with so many robots and such a turn."""
    samples = np.concatenate([one["samples"] for one in flights])  # type: ignore[misc]
    t, error, sigma, nees = samples.T
    confident = nees > CONFIDENT
    parts = []
    for begin, end in itertools.pairwise(PHASES):
        inside = (t >= begin) & (t < end)
        means = (float(np.mean(one[inside] ** 2)) ** 0.5 for one in (error, sigma) if inside.any())
        parts.append(" / ".join(f"{one:.1f}" for one in means) or "–")
    worst = error[confident].max() if confident.any() else 0.0
    told = np.array([one["said"] for one in flights], dtype=np.float64)
    said = f"{np.nanmedian(told):.1f}" if not np.isnan(told).all() else "–"
    seen = sum(one["seen"] for one in flights)  # type: ignore[misc]
    return [
        str(robots), f"{rate_deg_s:g}", str(len(flights)), f"{100.0 * confident.mean():.1f} %",
        f"{worst:.1f}", *parts, f"{100.0 * len(samples) / max(1, seen):.0f} %",
        f"{np.mean(~np.isnan(told)):.0%}", said, str(sum(one["names"] for one in flights)),  # type: ignore[misc]
    ]  # fmt: skip


HEADS = (
    "robots", "deg/s", "flights", "wrong and confident", "worst of these m",
    "turns: error / sigma m", "stays", "back", "right again", "positions", "said", "after s",
    "extra names",
)  # fmt: skip


def main() -> int:
    """Fly and print the table."""
    parser = arguments(
        str(__doc__), "1,2,3", "hover 10,hover 30,orbit 10,orbit 30", "yaw,pitch,roll"
    )
    parser.add_argument("--rates", default="0,0.5,1,2,5,10,20", help="deg/s")
    parser.add_argument("--camera", action="store_true", help="the camera turns, not telemetry")
    given = parser.parse_args()
    seed, rows = itertools.count(given.first_seed), []
    for robots, rate in itertools.product(given.robots.split(","), given.rates.split(",")):
        found = []
        for flight, motion, axis, _ in itertools.product(
            given.flights.split(","), given.motion.split(","), given.axes.split(","),
            range(given.seeds),
        ):  # fmt: skip
            case = Case(cell_of(flight, motion), int(robots), axis, float(rate), given.camera)
            found.append(flown(case, next(seed)))
        rows.append(row(int(robots), float(rate), found))
        print(" | ".join(rows[-1]), file=sys.stderr, flush=True)
    table = columns(list(HEADS), rows)
    show(table, given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
