# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Does every robot keep its name? Crossings, dives, missed and false boxes; IDF1, HOTA, switches.

python benchmarks/identity.py --seeds 3 --json identity.json --markdown identity.md

IDF1 and switches are counted by motmetrics over the images in which a robot has a true box. A name
is where the robot is whose box it took, known from the simulation: errors of position do not enter.
Names match robots within a hull's length; so two robots that pass closer than that may be taken for
one another in an image, but not any longer. HOTA is that of `evaluation.identity`. A robot that
dives is not in view; that it surfaces under its old name shows in switches and IDF1.

A name belongs to the robot that bore it first. `wrong names` counts how often it went to another
one more than a hull's length away; `unsaid` in how many images that was published with an ellipse
of 99.9 % that does not reach from that robot to the name's own: confident and wrong. `new names`
are those beyond the robots seen.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import results
from tables import show

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.identity.labels import Labels
from aerial_gnss_ros.core.tracker.protocol import TrackUpdate
from aerial_gnss_ros.core.tracker.tracker import Tracker
from aerial_gnss_ros.core.values.estimates import FrameResult, State
from aerial_gnss_ros.evaluation.identity import EXPLAINED, Identities, scores
from aerial_gnss_ros.evaluation.identity import Scene as Sight
from aerial_gnss_ros.simulation.boxes import DetectorPlan
from aerial_gnss_ros.simulation.experiment import (
    CameraClock,
    Experiment,
    default_camera,
)
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.hexapod import LENGTH
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import sensor_plan

NAMES = ("wrong_names", "unsaid", "new_names")
"""Counts of names in the table."""

HEADS = (
    "scene", "flights", "no switch", "IDF1", "HOTA", "AssA", "switches", "wrong names", "unsaid",
    "new names", "misses", "false", "images",
)  # fmt: skip

_DEEPEST_S = 90.0
"""When the first of robots that dive together is deepest, s."""


@dataclass(frozen=True)
class Scene:
    """One kind of trouble.

    Attributes:
        words: what it is.
        flight: the drone's.
        swim: the robots'.
        robots: how many, where `places` is empty.
        places: East, North of robots, m.
        detector: how it fails.
        together: all are seen at first, and dive at about the same time.
    """

    words: str
    flight: FlightPlan
    swim: SwimPlan
    robots: int = 3
    places: tuple[tuple[float, float], ...] = ()
    detector: DetectorPlan = field(default_factory=DetectorPlan)
    together: bool = False


_CROSSING = SwimPlan(0.3, 0.7, roam_m=5.0, apart_m=0.8)
_DIVING = SwimPlan(0.1, 0.3, roam_m=5.0, apart_m=1.5, dives=True, dive_s=120.0, dive_every_s=170.0)
_VARIED = replace(_DIVING, dive_s=150.0, shortest_dive_s=30.0)
SCENES = (
    Scene("three robots crossing", FlightPlan("orbit", 90.0, 20.0, speed_mps=3.0), _CROSSING),
    Scene("ten robots crossing", FlightPlan("orbit", 90.0, 30.0, speed_mps=3.0), _CROSSING, 10),
    Scene(
        "three dive together for 118 s", FlightPlan("orbit", 190.0, 30.0, speed_mps=3.0),
        SwimPlan(0.1, 0.3, roam_m=5.0, apart_m=1.5, dives=True, dive_s=166.0, dive_every_s=240.0),
        together=True,
    ),
    Scene("three dive at any time", FlightPlan("orbit", 400.0, 30.0, speed_mps=3.0), _DIVING),
    Scene("dives of varied length", FlightPlan("orbit", 400.0, 30.0, speed_mps=3.0), _VARIED),
    Scene(
        "20 % missed, 5 % false boxes", FlightPlan("orbit", 90.0, 20.0, speed_mps=3.0),
        SwimPlan(0.15, 0.6), 3, (), DetectorPlan(2.0, 0.2, 0.15),
    ),
    Scene(
        "two robots 1 m apart, 30 m high", FlightPlan("hover", 90.0, 30.0),
        SwimPlan(0.05, 0.1, roam_m=0.3, apart_m=0.9), 2, ((0.0, 0.0), (1.0, 0.0)),
    ),
)  # fmt: skip


class Watched(Tracker):
    """A tracker that notes which box gave each name its position."""

    def __init__(self, stated: EstimatorConfig) -> None:
        super().__init__(stated, Labels(stated))
        self.boxes: dict[int, dict[str, tuple[float, ...]]] = {}

    def update(self, frame: PosedFrame, points: WaterPoints, local: LocalMap) -> TrackUpdate:
        """Take in one image (see `Tracking`)."""
        done = super().update(frame, points, local)
        image = frame.detections
        # A simulated box has exactly its true size, which says whose it is; score order does not.
        self.boxes[image.stamp_ns] = {
            name: tuple(image.sizes[index]) for name, index in done.measured.items()
        }
        return done


@dataclass
class Owners:
    """Whose each name is, and how often it was on another robot.

    Attributes:
        of: robot that bore each name first.
        wrong: how often a name went to another robot.
        unsaid: images in which that was published as certain.
        errors: of each position of a robot in sight: NEES against the robot that the name belongs
            to, squared error and trace of the covariance, m².
    """

    of: dict[str, int] = field(default_factory=dict)
    wrong: int = 0
    unsaid: int = 0
    errors: list[tuple[float, float, float]] = field(default_factory=list)
    _now: set[tuple[str, int]] = field(default_factory=set)

    def update(self, worn: dict[str, int], places: np.ndarray, result: FrameResult) -> None:
        """Take in an image.

        Args:
            worn: robot by name.
            places: (n, 2) true East, North of all robots, m.
            result: what was published.
        """
        estimates = {one.robot_id: one for one in result.estimates}
        for name, one in estimates.items():
            if one.state is State.CONFIRMED and name in self.of:
                error, spread = one.position - places[self.of[name]], one.covariance[:2, :2]
                nees = float(error @ np.linalg.solve(spread, error))
                self.errors.append((nees, float(error @ error), float(np.trace(spread))))
        now = set()
        for name, robot in worn.items():
            owner = places[self.of.setdefault(name, robot)]
            if np.hypot(*(owner - places[robot])) > LENGTH:
                now.add((name, robot))
                # What the name alone makes wrong: errors of the platform are counted elsewhere.
                error = owner - places[robot]
                nees = error @ np.linalg.solve(estimates[name].covariance[:2, :2], error)
                self.unsaid += int(nees > EXPLAINED)
        self.wrong += len(now - self._now)
        # A robot that is out of sight goes on bearing its name.
        self._now = now | {(name, robot) for name, robot in self._now if name not in worn}


def measure(scene: Scene, seed: int) -> tuple[Identities | None, dict[str, int]]:
    """Return the scores of one flight, and counts of names by column."""
    made = Experiment(
        GeneratedFlight(scene.flight, seed), default_camera(1280, 720), sensor_plan("consumer"),
        CameraClock(10.0), robots=scene.robots,
        places=np.array(scene.places) if scene.places else None, swim=scene.swim,
        detector=scene.detector, seed=seed,
    )  # fmt: skip
    if scene.together:
        deepest = _DEEPEST_S + 3.0 * np.arange(scene.robots)
        phase = 0.5 - deepest / scene.swim.dive_every_s
        made.swarm._dive_phase = phase  # noqa: SLF001 - a flight draws it by chance
    found, _, counts = named(made, {})
    return found, counts


def named(
    made: Experiment, stated: dict[str, object]
) -> tuple[Identities | None, Owners, dict[str, int]]:
    """Return the scores of a flight, whose each name was, and counts of names by column.

    Args:
        made: the flight.
        stated: parameters of the estimator beside the origin of its map.
    """
    origin = made.flight.origin
    config = estimator_config(
        {"map.latitude_deg": np.degrees(origin.latitude),
         "map.longitude_deg": np.degrees(origin.longitude)} | stated
    )  # fmt: skip
    tracker = Watched(config)
    images = list(made.detections())
    found = results(made, config, images, tracker)
    names: dict[str, int] = {}
    owners = Owners()
    sights = []
    for (frame, boxes, _), result in zip(images, found, strict=True):
        places = made.swarm.positions(np.array([frame.t]))[:, 0, :2]
        robots = np.array([made.swarm.names.index(name) for name in boxes.names], dtype=np.intp)
        sizes = [tuple(size) for size in boxes.sizes]
        taken = tracker.boxes.get(frame.stamp_ns, {})
        numbers = [names.setdefault(name, len(names)) for name in taken]
        apart = np.full((len(robots), len(taken)), np.inf)
        for j, size in enumerate(taken.values()):
            if size in sizes:  # not a false box
                away = places[robots] - places[robots[sizes.index(size)]]
                apart[:, j] = np.hypot(away[:, 0], away[:, 1])
        sights.append(Sight(robots, np.array(numbers, dtype=np.intp), apart))
        worn = {
            name: int(robots[sizes.index(size)]) for name, size in taken.items() if size in sizes
        }
        owners.update(worn, places, result)
    new = len(names) - len({int(robot) for sight in sights for robot in sight.robots})
    counts = {"wrong_names": owners.wrong, "unsaid": owners.unsaid, "new_names": max(new, 0)}
    return scores(sights, LENGTH), owners, counts


def row(scene: Scene, found: list[tuple[Identities | None, dict[str, int]]]) -> dict[str, object]:
    """Return one line of the table."""
    good = [one for one, _ in found if one is not None]
    means = {
        name: float(np.mean([getattr(one, name) for one in good]))
        for name in ("hota", "assa", "idf1")
        if good and getattr(good[0], name) is not None
    }
    sums = {
        name: sum(getattr(one, name) or 0 for one in good)
        for name in ("switches", "misses", "false_names", "images")
    }
    sums |= {name: sum(counts[name] for _, counts in found) for name in NAMES}
    clean = sum(one.switches == 0 for one in good)
    return {"scene": scene.words, "flights": len(good), "clean": clean, **means, **sums}


def markdown(rows: list[dict[str, object]]) -> str:
    """Return the table."""
    lines = [
        f"| {' | '.join(HEADS)} |",
        "|---" + "|---:" * (len(HEADS) - 1) + "|",
    ]
    for one in rows:
        means = " | ".join(f"{one.get(key, float('nan')):.3f}" for key in ("idf1", "hota", "assa"))
        columns = ("switches", *NAMES, "misses", "false_names", "images")
        counts = " | ".join(str(one[k]) for k in columns)
        lines.append(f"| {one['scene']} | {one['flights']} | {one['clean']} | {means} | {counts} |")
    return "\n".join(lines) + "\n"


def main() -> int:
    """Fly all scenes and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="flights a scene")
    parser.add_argument("--first", type=int, default=0, help="seed of the first one")
    parser.add_argument("--only", default="", help="scenes whose words hold this")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--markdown", type=Path)
    given = parser.parse_args()
    rows = []
    for scene in SCENES:
        if given.only in scene.words:
            seeds = range(given.first, given.first + given.seeds)
            rows.append(row(scene, [measure(scene, seed) for seed in seeds]))
            print(markdown(rows).splitlines()[-1], file=sys.stderr, flush=True)
    show(markdown(rows), given.markdown)
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
