# SPDX-License-Identifier: Apache-2.0
"""A gimbal that turns by itself: what is published, and what is said. See docs/estimation.md.

python benchmarks/runaway.py --markdown runaway.md

From 20 s on telemetry turns by itself for 10 s, about one axis, stays turned for 10 s, turns back
as fast, and is right again; the camera does not turn (`--camera`: the camera turns so, and
telemetry does not tell). Robots and sensors are else as stated; the receiver is RTK, the robots'
acceleration and greatest speed are the defaults. NEES is e' P^-1 e of a robot's East and North;
above 13.8 (one in a thousand of a right covariance) the position counts as wrong and confident. A
row is of hovers and orbits, still and moving robots, and all three axes, each flight of a seed of
its own. Errors are of robots in sight.
"""

from __future__ import annotations

import argparse
import itertools
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import Cell, Setting, config, experiment, results, robots_of, truth
from numpy.typing import ArrayLike, NDArray
from tables import columns, show

from aerial_gnss_ros.core.estimator import Estimator
from aerial_gnss_ros.core.gimbal import error_axes
from aerial_gnss_ros.core.joint_geometry import rotation_matrix
from aerial_gnss_ros.core.values import FrameResult, MapDatum, State
from aerial_gnss_ros.simulation.experiment import LEAD_S, Experiment
from aerial_gnss_ros.simulation.flight import Flight, Motion
from aerial_gnss_ros.simulation.sensors import START_NS, Sensors

Array = NDArray[np.float64]

AXES = {"roll": 0, "pitch": 1, "yaw": 2}
BEGIN_S, RUN_S, STAY_S, SETTLE_S = 20.0, 10.0, 10.0, 10.0
END_S = BEGIN_S + 2.0 * RUN_S + STAY_S + SETTLE_S
CONFIDENT = 13.8
"""Squared distance that one in a thousand of a planar normal law exceeds."""
STATED = {"noise.robot_acceleration": 0.05, "tracks.max_speed": 1.5}
"""The defaults, also where robots stay: nobody told that they would."""


@dataclass(frozen=True)
class Turned:
    """A flight whose camera is turned about an axis, by an angle (rad) at each time (s)."""

    flight: Flight
    axis: str
    angle: Callable[[Array], Array]

    @property
    def origin(self) -> MapDatum:
        """As the flight's own."""
        return self.flight.origin

    @property
    def duration_s(self) -> float:
        """As the flight's own."""
        return self.flight.duration_s

    @property
    def words(self) -> str:
        """As the flight's own."""
        return self.flight.words

    def sample(self, t: ArrayLike) -> Motion:
        """Return the motion with the camera turned."""
        motion = self.flight.sample(t)
        turned = motion.enu_from_camera.copy()
        for i, angle in enumerate(self.angle(motion.t)):
            axis = error_axes(turned[i])[:, AXES[self.axis]]
            turned[i] = rotation_matrix(angle * axis) @ turned[i]
        return replace(motion, enu_from_camera=turned)


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
        camera: whether the camera turns and telemetry does not tell.
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
            margin = LEAD_S + abs(made.clock.latency_s)
            span = -margin, made.flight.duration_s + margin
            made.sensors = Sensors(turned, made.sensors_plan, seed, *span)
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
        for one in result.estimates:
            places = frame.positions
            if one.robot_id in names:
                error = one.position - places[names[one.robot_id]]
            else:  # a new name: whichever is nearest
                apart = one.position - places
                error = apart[np.argmin(np.linalg.norm(apart, axis=1))]
            P = one.covariance[:2, :2]
            squared = float(error @ np.linalg.solve(P, error))
            sigma = math.sqrt(0.5 * float(np.trace(P)))
            if one.state is State.CONFIRMED:
                samples.append((image.t, float(np.hypot(*error)), sigma, squared))
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
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--seeds", type=int, default=1, help="flights of each kind (default 1)")
    parser.add_argument("--first-seed", type=int, default=0, help="the first one (default 0)")
    parser.add_argument("--rates", default="0,0.5,1,2,5,10,20", help="deg/s")
    parser.add_argument("--axes", default="yaw,pitch,roll", help="of yaw, pitch, roll")
    parser.add_argument("--robots", default="1,2,3", help="how many, comma separated")
    parser.add_argument("--flights", default="hover 10,hover 30,orbit 10,orbit 30", help="families")
    parser.add_argument("--motion", default="still,moving", help="of still, moving")
    parser.add_argument("--camera", action="store_true", help="the camera turns, not telemetry")
    parser.add_argument("--markdown", type=Path, help="write the table here too")
    given = parser.parse_args()
    seed, rows = itertools.count(given.first_seed), []
    for robots, rate in itertools.product(given.robots.split(","), given.rates.split(",")):
        found = []
        for flight, motion, axis, _ in itertools.product(
            given.flights.split(","), given.motion.split(","), given.axes.split(","),
            range(given.seeds),
        ):  # fmt: skip
            family, height = flight.split()
            cell = Cell(family, float(height), "rtk", motion == "moving")
            case = Case(cell, int(robots), axis, float(rate), given.camera)
            found.append(flown(case, next(seed)))
        rows.append(row(int(robots), float(rate), found))
        print(" | ".join(rows[-1]), file=sys.stderr, flush=True)
    table = columns(list(HEADS), rows)
    show(table, given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
