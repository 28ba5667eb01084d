# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drones that are joined over a poor link: bytes, processor time, and what catching up gives.

python benchmarks/fleet_link.py --markdown docs/results/fleet.md

Robots swim or stay: where they stay, a second law of all of them is tried. Each flight's sightings
pass as JSON, as over the topic `sightings`, with delay, loss and an outage in turn, and the fleet
takes them in ten times a second, as the node does. Counted is the processor time of one core for
reading and joining; publishing is not in it.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from tables import columns, show

from aerial_gnss_ros.adapters.sighting_messages import sent_sighting, sighting_text
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.fleet.outbox import SECOND_NS, Outbox, SentSighting
from aerial_gnss_ros.core.fleet.shore import Shore
from aerial_gnss_ros.core.fleet.sighting import SightingTap
from aerial_gnss_ros.core.tracker.protocol import Tracking
from aerial_gnss_ros.core.tracker.tracker import Tracker
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum
from aerial_gnss_ros.simulation.boxes import DetectorPlan
from aerial_gnss_ros.simulation.experiment import Experiment, default_camera
from aerial_gnss_ros.simulation.feeding import AHEAD_S, feed_in_time
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.formation import Formation, together
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import START_NS, sensor_plan

TICK_S = 0.1
RESENT_S = 1.2
"""From a loss to its second arrival: asked for within a second."""
RESENT_HZ = 100.0

Arrivals = list[tuple[float, str, str]]
"""Time of arrival, s; drone; message."""


@dataclass(frozen=True)
class Cell:
    """One flight.

    Attributes:
        drones: number of them.
        robots: likewise.
        duration_s: length.
        links: what happens to the second drone's sightings.
        speed: of the robots, m/s.
    """

    drones: int
    robots: int
    duration_s: float
    links: tuple[str, ...]
    speed: float = 0.3


CELLS = (
    Cell(2, 3, 80.0, ("in time", "2 s late", "30 % lost", "60 s outage")),
    Cell(4, 30, 12.0, ("in time", "2 s late")),
    Cell(4, 30, 12.0, ("in time", "2 s late"), 0.0),
)


def flown(cell: Cell) -> tuple[dict[str, list[SentSighting]], EstimatorConfig, MapDatum]:
    """Return what the drones of a flight send, the parameters of each, and the origin of map."""
    plan = sensor_plan("consumer")
    config = estimator_config({"fix.altitude_datum": "ellipsoid"})

    def first(flight: GeneratedFlight, others: Sequence[GeneratedFlight]) -> Experiment:
        return Experiment(
            flight, default_camera(1280, 720), plan, robots=cell.robots,
            swim=SwimPlan(cell.speed, cell.speed), detector=DetectorPlan(2.0, 0.0, 0.0), seed=7,
            others=others,
        )  # fmt: skip

    path = FlightPlan(kind="orbit", duration_s=cell.duration_s, height_m=30.0)
    formation = Formation("opposite", cell.drones, 0.5)
    made = together(first, path, formation, 7, [plan] * cell.drones)
    sent = {}
    for name, one in made.items():
        estimator, taps = Estimator(config), list[SightingTap]()

        def tapped(tracker: Tracking, taps: list[SightingTap] = taps) -> SightingTap:
            assert isinstance(tracker, Tracker)  # noqa: S101 - the default one
            taps.append(taps[0] if taps else SightingTap(tracker))
            taps[0].follow(tracker)
            return taps[0]

        estimator.wrap_tracking(tapped)
        estimator.add_camera(START_NS - 10**9, one.camera)

        def see(boxes: DetectionFrame, estimator: Estimator = estimator) -> None:
            estimator.add_detections(boxes)
            estimator.advance(boxes.stamp_ns + round(AHEAD_S * SECOND_NS))

        feed_in_time(estimator, one.sensors, (boxes for _, _, boxes in one.detections()), see)
        estimator.flush()
        outbox = Outbox(name)
        sent[name] = [outbox.add(seen) for seen in taps[0].drain()]
    return sent, config, made["a"].flight.origin


def arrivals(sent: dict[str, list[SentSighting]], link: str, seed: int) -> Arrivals:
    """Return when each sighting arrives; all but the second drone's do so after 0.1 s."""
    rng, found = np.random.default_rng(seed), Arrivals()
    for number, (name, of) in enumerate(sent.items()):
        again = 0
        for one in of:
            at_s = (one.sighting.pose.stamp_ns - START_NS) / SECOND_NS + 0.1
            if number == 1 and link == "2 s late":
                at_s += 2.0
            elif number == 1 and link == "30 % lost" and rng.random() < 0.3:
                at_s += RESENT_S
            elif number == 1 and link == "60 s outage" and 10.0 <= at_s < 70.0:
                again += 1
                at_s = 70.0 + RESENT_S + again / RESENT_HZ
            found.append((at_s, name, sighting_text(one)))
    return sorted(found)


@dataclass
class Joined:
    """What the fleet gave.

    Attributes:
        result: after all sightings.
        names: the fleet's by the drones' own.
        spent_s: processor time.
        longest_s: of one of the ten times a second.
        applied: number of sightings applied, again and again as often as that was.
    """

    result: FrameResult | None
    names: dict[str, dict[str, str]]
    spent_s: float
    longest_s: float
    applied: int


def join(came: Arrivals, config: EstimatorConfig, origin: MapDatum) -> Joined:
    """Take in sightings as they arrive."""
    drones = sorted({name for _, name, _ in came})
    now_s, began_s = 0.0, time.process_time()

    def clock() -> int:
        return round((now_s + time.process_time() - began_s) * SECOND_NS)

    shore = Shore(drones, 0.5, origin, clock)
    for name in drones:
        shore.describe(name, name, config, None)
    result, spent_s, longest_s, place = None, 0.0, 0.0, 0
    history = shore.history
    assert history is not None  # noqa: S101 - all drones are known
    while place < len(came) or history.waiting:
        began_s = time.process_time()
        while place < len(came) and came[place][0] <= now_s:
            _, name, text = came[place]
            shore.add(name, sent_sighting(text), START_NS + round(now_s * SECOND_NS))
            place += 1
        result = shore.advance() or result
        took_s = time.process_time() - began_s
        spent_s, longest_s = spent_s + took_s, max(longest_s, took_s)
        now_s += max(TICK_S, took_s)
    names = {one.drone: one.update.names for one in shore.links.values() if one.update is not None}
    return Joined(result, names, spent_s, longest_s, history.applied)


def apart_m(one: FrameResult | None, other: FrameResult | None) -> float:
    """Return the largest distance of a robot between two results, m; infinity if names differ."""
    if one is None or other is None:
        return math.inf
    places = {e.robot_id: e.position for e in other.estimates}
    if places.keys() != {e.robot_id for e in one.estimates}:
        return math.inf
    return max(float(np.linalg.norm(e.position - places[e.robot_id])) for e in one.estimates)


HEADS = [
    "drones", "robots", "motion", "second drone", "kB/s each", "core, %", "applied", "longest, s",
    "apart, mm", "names",
]  # fmt: skip


def rows(cell: Cell) -> list[list[str]]:
    """Return the table's rows of a flight."""
    sent, config, origin = flown(cell)
    found, first = list[list[str]](), Joined(None, {}, 0.0, 0.0, 0)
    for link in cell.links:
        came = arrivals(sent, link, 3)
        joined = join(came, config, origin)
        first = first if found else joined
        size = sum(len(text) for _, _, text in came) / cell.drones / cell.duration_s
        same = "equal" if joined.names == first.names else "differ"
        found.append(
            [
                str(cell.drones), str(cell.robots), "swim" if cell.speed else "stay", link,
                f"{size / 1e3:.1f}",
                f"{100.0 * joined.spent_s / cell.duration_s:.0f}",
                f"{joined.applied / len(came):.1f}", f"{joined.longest_s:.2f}",
                f"{1e3 * apart_m(joined.result, first.result):.3f}", same,
            ]
        )  # fmt: skip
    return found


def main() -> int:
    """Fly and print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--cells", type=int, nargs="*", help="numbers of flights (default all)")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    chosen = range(len(CELLS)) if given.cells is None else given.cells
    show(columns(HEADS, [row for n in chosen for row in rows(CELLS[n])]), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
