# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""False boxes an image, and what the estimator makes of them: false robots a minute.

python benchmarks/false_robots.py --flights 5 --markdown docs/results/detection.md

Simulated flights of 40 s (hover 10 m, orbit 20 m, transit 20 m; RTK, 5 images a second) over three
swimming robots, with false boxes added as the detector has them on photographs of water that its
second look has not seen: as many of each kind, with their scores, as `unseen_water.py` prints for
each source with `--weight 0.5 --shift -0.9` (`SCENES`, `SCORES`; of all that is false at the shore
the scores are those of boat lifts, and the North Sea's one boat counts as a swimmer). How long a
thing lasts and how it moves is not in photographs, and is stated here: swimmers swim, boats drift,
docks stay; foam dissolves (mean of 1 s) and drifts; glint flashes at one place of the image. A
glimpse is a swimmer between waves, seen for 0.5 to 3 s. `foam` and `glint` have six times as many
boxes as the worst water, all of one kind. Scores of one thing
are alike: of their variance, a part is the thing's, and the rest changes in 0.3 s
(`lasting_scores.py`). A false robot is a name whose first position is farther than 2 m from every
robot.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import ORIGIN, Cell, Image, Setting, experiment, results
from numpy.typing import NDArray
from tables import columns, show
from unseen_water_tables import QUANTILES

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult, State
from aerial_gnss_ros.core.values.rejection import Reason
from aerial_gnss_ros.simulation.chance import generator
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, Frame
from aerial_gnss_ros.simulation.view import project_points

Array = NDArray[np.float64]

DURATION_S, RATE_HZ, FALSE_M, NEAR_PX = 40.0, 5.0, 2.0, 12.0
SCORES = {
    "robot": (0.33, 0.62, 0.80, 0.85, 0.89, 0.92, 0.95),
    "swimmer": (0.31, 0.33, 0.35, 0.52, 0.64, 0.67, 0.72),
    "boat": (0.33, 0.33, 0.34, 0.44, 0.56, 0.61, 0.65),
    "glimpse": (0.31, 0.33, 0.35, 0.52, 0.64, 0.67, 0.72),
    "foam": (0.31, 0.32, 0.32, 0.34, 0.38, 0.45, 0.49),
    "glint": (0.33, 0.35, 0.40, 0.43, 0.45, 0.48, 0.49),
    "dock": (0.31, 0.33, 0.34, 0.55, 0.81, 0.85, 0.88),
}
"""Scores of boxes at `QUANTILES`: robots composed onto the lake, false boxes of each kind."""
LENGTHS_M = {"swimmer": (0.5, 1.7), "glimpse": (0.5, 1.7), "boat": (2.0, 7.0), "dock": (0.4, 10.0),
             "foam": (0.2, 1.5), "glint": (0.1, 1.0)}  # fmt: skip
SPEEDS_MPS = {"swimmer": 0.3, "glimpse": 0.3, "boat": 0.2, "dock": 0.0, "foam": 0.15}
FOUND = {"robot": 0.9, "swimmer": 0.7, "glimpse": 0.7, "boat": 0.7, "dock": 0.5, "foam": 0.7}
"""Share of the images in which a thing has a box."""
FOAM_S, GLIMPSE_S = 1.0, (0.5, 3.0)
OWN_SHARE, CHANGE_S = {"robot": 0.75}, 0.3
"""Of the variance of one thing's scores, what stays (others: 0.3); how fast the rest changes, s."""
STAYING = 0.5  # share of the glints that are in the next image, too
SCENES: dict[str, dict[str, float]] = {
    "none": {},
    "North Sea: swimmers, some foam": {"swimmer": 0.25, "foam": 0.06},
    "swimmers between waves": {"glimpse": 0.25},
    "lake from above: boats, glint": {"boat": 0.12, "glint": 0.12},
    "shore: docks, stones": {"dock": 0.13},
    "foam that lasts for 1 s in the mean": {"foam": 1.86},
    "glint, at one place of the image": {"glint": 1.86},
}
CELLS = (("hover", 10.0), ("orbit", 20.0), ("transit", 20.0))
STATED: dict[str, dict[str, object]] = {
    "": {},
    "length": {"classes.aqua.length_m": [0.4, 0.9]},
    "score": {"tracks.confirm_score": 0.65},
    "length and score": {"classes.aqua.length_m": [0.4, 0.9], "tracks.confirm_score": 0.65},
}
HEADS = ["clutter", "stated", "false boxes an image", "not `wrong_size`", "false robots a minute",
         "these coasting, an image", "robots found", "until confirmed, s"]  # fmt: skip


def score(kind: str, level: Array | float) -> Array:
    """Return scores at standard normal deviates."""
    share = 0.5 * (1.0 + np.vectorize(math.erf)(np.asarray(level) / math.sqrt(2.0)))
    return np.asarray(np.interp(share, QUANTILES, SCORES[kind]))


@dataclass(frozen=True)
class Thing:
    """Something that has boxes.

    Attributes:
        kind: key of `SCORES`.
        begin, end: when there is something, s.
        place: (2,) East, North at the beginning, m.
        velocity: (2,) m/s.
        length_m: of its box.
        level: of its scores, a standard normal deviate.
    """

    kind: str
    begin: float
    end: float
    place: Array
    velocity: Array
    length_m: float
    level: float


def seen_at(made: Experiment, frame: Frame, pixel: Array) -> Array | None:
    """Return East, North of the water at a pixel; None: no water within 150 m.

    Distortion is left out.
    """
    ray = frame.pose.enu_from_optical @ np.linalg.solve(made.camera.K, [*pixel, 1.0])
    if ray[2] >= 0.0:
        return None
    away = -frame.pose.position[2] / ray[2] * ray
    if float(np.hypot(*away[:2])) > 150.0:
        return None
    return np.asarray((frame.pose.position + away)[:2])


def things(
    made: Experiment, frames: list[Frame], kind: str, rate: float, seed: int
) -> Iterator[Thing]:
    """Yield as many things of a kind that they have `rate` boxes an image in the mean."""
    rng = generator(seed, kind)
    size = np.array([made.camera.width, made.camera.height], dtype=np.float64)
    visible, wanted = 0.0, rate / FOUND[kind] * len(frames)
    while visible < wanted:
        frame = frames[int(rng.integers(len(frames)))]
        spot = seen_at(made, frame, size * rng.random(2))
        if spot is None:
            continue
        begin, end = -1e3, 1e3
        if kind == "foam":
            begin = frame.t - rng.random() / RATE_HZ
            end = begin + rng.exponential(FOAM_S)
        elif kind == "glimpse":
            begin = frame.t - rng.random() / RATE_HZ
            end = begin + rng.uniform(*GLIMPSE_S)
        course = rng.uniform(-math.pi, math.pi)
        velocity = SPEEDS_MPS[kind] * np.array([math.cos(course), math.sin(course)])
        low, high = np.log(LENGTHS_M[kind])
        thing = Thing(
            kind, begin, end, spot - velocity * (frame.t - max(begin, 0.0)), velocity,
            float(np.exp(rng.uniform(low, high))), float(rng.standard_normal()),
        )  # fmt: skip
        alive = [one for one in frames if begin <= one.t <= end]
        some = alive[:: max(1, len(alive) // 12)]
        shown = sum(bool(boxes_of(made, one, [thing])) for one in some)
        visible += len(alive) * shown / max(1, len(some))
        yield thing


def boxes_of(
    made: Experiment, frame: Frame, every: list[Thing]
) -> list[tuple[Thing, Array, float]]:
    """Return the things in view of an image, with centre and length, px."""
    alive = [one for one in every if one.begin <= frame.t <= one.end]
    if not alive:
        return []
    spots = np.array([
        [*(one.place + one.velocity * (frame.t - max(one.begin, 0.0))), 0.0] for one in alive
    ])  # fmt: skip
    pixels, _ = project_points(made.camera, frame.pose, spots)
    away = np.linalg.norm(frame.pose.position - spots, axis=1)
    inside = made.camera.inside(pixels)
    return [
        (one, pixels[i], one.length_m * made.camera.K[0, 0] / away[i])
        for i, one in enumerate(alive) if inside[i]
    ]  # fmt: skip


def glints(made: Experiment, count: int, rate: float, seed: int) -> list[list[tuple[Array, float]]]:
    """Return centres and lengths, px, of the glints in each of `count` images."""
    rng = generator(seed, "glint")
    size = np.array([made.camera.width, made.camera.height], dtype=np.float64)
    middle, shown = size * rng.uniform(0.25, 0.75, 2), list[tuple[Array, float]]()
    images = []
    for _ in range(count):
        shown = [
            (at + rng.normal(0.0, 4.0, 2), long) for at, long in shown if rng.random() < STAYING
        ]
        shown += [
            (middle + rng.normal(0.0, 0.1 * size[0], 2), float(rng.uniform(12.0, 40.0)))
            for _ in range(int(rng.poisson(rate * (1.0 - STAYING))))
        ]
        images.append(list(shown))
    return images


class Level:
    """Scores of one thing, as standard normal deviates that are alike.

    Args:
        kind: key of `SCORES`.
        own: its own deviate, which stays.
    """

    def __init__(self, kind: str, own: float) -> None:
        self._own, self._change, self._t = own, 0.0, -math.inf
        self._share = OWN_SHARE.get(kind, 0.3)

    def at(self, t: float, rng: np.random.Generator) -> float:
        """Return the deviate in the image of a time, s, later than those before."""
        kept = math.exp((self._t - t) / CHANGE_S)
        self._change = kept * self._change + math.sqrt(1.0 - kept**2) * rng.standard_normal()
        self._t = t
        return math.sqrt(self._share) * self._own + math.sqrt(1.0 - self._share) * self._change


def clutter(
    made: Experiment, clean: list[Image], scene: dict[str, float], seed: int
) -> list[Image]:
    """Return a flight's images with false boxes, and robots with measured scores and misses."""
    rng = generator(seed, "boxes")
    frames = [frame for frame, _, _ in clean]
    every = [
        thing for kind, rate in scene.items() if kind != "glint"
        for thing in things(made, frames, kind, rate, seed)
    ]  # fmt: skip
    flashes = glints(made, len(frames), scene.get("glint", 0.0), seed)
    levels = {name: Level("robot", float(rng.standard_normal())) for name in made.swarm.names}
    of_things = {id(thing): Level(thing.kind, thing.level) for thing in every}
    images = []
    for (frame, boxes, found), flashing in zip(clean, flashes, strict=True):
        rows: list[tuple[Array, float, str, float]] = [
            (
                centre + rng.normal(0.0, 2.0, 2), float(max(size)), "robot",
                levels[name].at(frame.t, rng),
            )
            for name, centre, size in zip(boxes.names, boxes.centers, boxes.sizes, strict=True)
            if rng.random() < FOUND["robot"]
        ]  # fmt: skip
        for thing, at, long in boxes_of(made, frame, every):
            if rng.random() < FOUND[thing.kind]:
                jitter = rng.normal(0.0, 2.0 + 0.05 * long, 2)
                level = of_things[id(thing)].at(frame.t, rng)
                rows.append((at + jitter, long, thing.kind, level))
        rows += [(at, long, "glint", float(rng.standard_normal())) for at, long in flashing]
        images.append((frame, boxes, _detections(made, found, rows)))
    return images


def _detections(
    made: Experiment, found: DetectionFrame, rows: list[tuple[Array, float, str, float]]
) -> DetectionFrame:
    centers = np.array([row[0] for row in rows]).reshape(-1, 2)
    scores = np.array([float(score(row[2], row[3])) for row in rows])
    sizes = np.array([[row[1], row[1] * 0.6] for row in rows]).reshape(-1, 2)
    inside = np.flatnonzero(made.camera.inside(centers)) if rows else np.zeros(0, np.int64)
    order = inside[np.argsort(-scores[inside], kind="stable")] if rows else inside
    return DetectionFrame(
        found.stamp_ns, found.frame_id, centers[order], sizes[order], scores[order],
        ("aqua",) * len(order),
    )  # fmt: skip


@dataclass
class Figures:
    """Counts over flights.

    Attributes:
        images: how many.
        boxes: false ones.
        refused: those that were refused as `wrong_size`.
        false: names that are no robots.
        coasting: how often one was published in an image that did not show it.
        found, robots: robots with a name, and all.
        waits: from a robot's first box to its name, s.
    """

    images: int = 0
    boxes: int = 0
    refused: int = 0
    false: int = 0
    coasting: int = 0
    found: int = 0
    robots: int = 0
    waits: list[float] | None = None

    def row(self, words: str, stated: str) -> list[str]:
        """Return a line of the table."""
        minutes = self.images / RATE_HZ / 60.0
        return [
            words, stated, f"{self.boxes / self.images:.2f}",
            f"{(self.boxes - self.refused) / self.images:.2f}",
            f"{self.false / minutes:.2f}",
            f"{self.coasting / self.images:.2f}", f"{self.found} of {self.robots}",
            f"{np.mean(self.waits or [math.nan]):.2f}",
        ]  # fmt: skip


def fly(words: str, stated: str, flights: int, first: int) -> Figures:
    """Return the counts of one kind of clutter over all cells and flights."""
    total = Figures(waits=[])
    for number in range(flights):
        for kind, height in CELLS:
            cell, seed = Cell(kind, height, "rtk", True), first + number
            made = experiment(cell, seed, Setting(duration_s=DURATION_S))
            made.clock = CameraClock(rate_hz=RATE_HZ)
            images = clutter(made, list(made.detections()), SCENES[words], seed)
            config = estimator_config({
                "map.latitude_deg": math.degrees(ORIGIN.latitude),
                "map.longitude_deg": math.degrees(ORIGIN.longitude),
                "fix.altitude_datum": "ellipsoid", "noise.gnss_offset_m": 0.02,
                **STATED[stated],
            })  # fmt: skip
            count(total, made, images, results(made, config, images))
    return total


def count(total: Figures, made: Experiment, images: list[Image], found: list[FrameResult]) -> None:
    """Add the counts of a flight."""
    total.images += len(images)
    start_ns = images[0][0].stamp_ns
    first: dict[str, float] = {}
    for frame, boxes, seen in images:
        away = np.linalg.norm(seen.centers[:, None] - boxes.centers[None], axis=2)
        near = away.min(axis=1, initial=np.inf) < NEAR_PX
        total.boxes += int((~near).sum())
        for name, near_one in zip(boxes.names, (away < NEAR_PX).any(axis=0), strict=True):
            if near_one:
                first.setdefault(name, (frame.stamp_ns - start_ns) * 1e-9)
    by_stamp = {frame.stamp_ns: (frame, boxes) for frame, boxes, _ in images}
    known: dict[str, str] = {}
    for result in found:
        frame, boxes = by_stamp[result.stamp_ns]
        for one in result.rejections:
            away = np.linalg.norm(boxes.centers - (one.u_px, one.v_px), axis=1)
            far = away.min(initial=np.inf) >= NEAR_PX
            total.refused += int(one.reason is Reason.WRONG_SIZE and far)
        places = made.swarm.positions(np.array([frame.t]))[:, 0, :2]
        for one in result.estimates:
            if one.robot_id in known:
                total.coasting += not known[one.robot_id] and one.state is State.COASTING
                continue
            apart = np.linalg.norm(places - one.position, axis=1)
            robot = made.swarm.names[int(apart.argmin())] if apart.min() < FALSE_M else ""
            if robot and robot not in known.values() and robot in first:
                assert total.waits is not None  # noqa: S101 - `fly` gave a list
                total.waits.append((result.stamp_ns - start_ns) * 1e-9 - first[robot])
            known[one.robot_id] = robot
    total.false += sum(not robot for robot in known.values())
    total.found += len({robot for robot in known.values() if robot} & set(first))
    total.robots += len(first)


def main() -> None:
    """Fly all, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--flights", type=int, default=3, help="of each of the three kinds")
    parser.add_argument("--first", type=int, default=7000, help="seed of the first flight")
    parser.add_argument("--only", nargs="+", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--stated", nargs="+", default=list(STATED), choices=list(STATED))
    parser.add_argument("--markdown", type=Path, metavar="PAGE")
    given = parser.parse_args()
    rows = [
        fly(words, stated, given.flights, given.first).row(words, stated)
        for words in given.only for stated in given.stated
    ]  # fmt: skip
    show(columns(HEADS, rows), given.markdown)


if __name__ == "__main__":
    main()
