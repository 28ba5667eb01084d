# SPDX-License-Identifier: Apache-2.0
"""Does every robot keep its name? Crossings, dives, missed and false boxes; IDF1, HOTA, switches.

python benchmarks/identity.py --seeds 3 --json identity.json --markdown identity.md

IDF1, switches and fragments are counted by motmetrics over the images in which a robot has a true
box, 2 m being the reach of a match after the errors that all robots share are taken out. A robot
that dives is not in view; that it surfaces under its old name shows in switches and IDF1.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from dataclasses import dataclass, field
from pathlib import Path

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402 - the number of threads comes first
from families import ORIGIN, results  # noqa: E402

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track  # noqa: E402
from aerial_gnss_ros.core.config import estimator_config  # noqa: E402
from aerial_gnss_ros.core.values import RobotEstimate, State  # noqa: E402
from aerial_gnss_ros.evaluation.errors import compare  # noqa: E402
from aerial_gnss_ros.evaluation.identity import Identities, identities  # noqa: E402
from aerial_gnss_ros.simulation.boxes import DetectorPlan  # noqa: E402
from aerial_gnss_ros.simulation.experiment import (  # noqa: E402
    CameraClock,
    Experiment,
    default_camera,
)
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight  # noqa: E402
from aerial_gnss_ros.simulation.robots import SwimPlan  # noqa: E402
from aerial_gnss_ros.simulation.sensors import sensor_plan  # noqa: E402


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
    """

    words: str
    flight: FlightPlan
    swim: SwimPlan
    robots: int = 3
    places: tuple[tuple[float, float], ...] = ()
    detector: DetectorPlan = field(default_factory=DetectorPlan)


_CROSSING = SwimPlan(0.3, 0.7, roam_m=5.0, apart_m=0.8)
_DIVING = SwimPlan(0.1, 0.3, roam_m=5.0, apart_m=1.5, dives=True, dive_s=120.0, dive_every_s=170.0)
SCENES = (
    Scene("three robots crossing", FlightPlan("orbit", 90.0, 20.0, speed_mps=3.0), _CROSSING),
    Scene("ten robots crossing", FlightPlan("orbit", 90.0, 30.0, speed_mps=3.0), _CROSSING, 10),
    Scene("three robots, dives of 120 s", FlightPlan("orbit", 400.0, 30.0, speed_mps=3.0), _DIVING),
    Scene(
        "20 % missed, 5 % false boxes", FlightPlan("orbit", 90.0, 20.0, speed_mps=3.0),
        SwimPlan(0.15, 0.6), 3, (), DetectorPlan(2.0, 0.2, 0.15),
    ),
    Scene(
        "two robots 1 m apart, 30 m high", FlightPlan("hover", 90.0, 30.0),
        SwimPlan(0.05, 0.1, roam_m=0.3, apart_m=0.9), 2, ((0.0, 0.0), (1.0, 0.0)),
    ),
)  # fmt: skip


def measure(scene: Scene, seed: int) -> Identities | None:
    """Return the scores of one flight."""
    made = Experiment(
        GeneratedFlight(scene.flight, seed), default_camera(1280, 720), sensor_plan("consumer"),
        CameraClock(10.0), robots=scene.robots,
        places=np.array(scene.places) if scene.places else None, swim=scene.swim,
        detector=scene.detector, seed=seed,
    )  # fmt: skip
    stated = estimator_config(
        {"map.latitude_deg": np.degrees(ORIGIN.latitude),
         "map.longitude_deg": np.degrees(ORIGIN.longitude)}
    )  # fmt: skip
    published: dict[str, list[RobotEstimate]] = {}
    for result in results(made, stated):
        for estimate in result.estimates:
            published.setdefault(estimate.robot_id, []).append(estimate)
    truth = {
        name: Track(
            np.array([fix.stamp_ns for fix in fixes], dtype=np.int64),
            np.array([fix.latitude for fix in fixes]),
            np.array([fix.longitude for fix in fixes]),
        )
        for name, fixes in made.robot_fixes()
    }
    seen: dict[str, list[int]] = {}
    for frame, boxes, _ in made.detections():
        for name in boxes.names:
            seen.setdefault(name, []).append(frame.stamp_ns)
    in_view = {name: np.array(stamps, dtype=np.int64) for name, stamps in seen.items()}
    tracks = {name: _track(rows) for name, rows in published.items()}
    return identities(tracks, truth, compare(tracks, truth), in_view)


def _track(rows: list[RobotEstimate]) -> EstimatedTrack:
    return EstimatedTrack(
        np.array([row.stamp_ns for row in rows], dtype=np.int64),
        np.array([row.latitude for row in rows]),
        np.array([row.longitude for row in rows]),
        np.array([row.covariance[:2, :2] for row in rows]),
        np.array([row.state is State.CONFIRMED for row in rows]),
    )


def row(scene: Scene, found: list[Identities | None]) -> dict[str, object]:
    """Return one line of the table."""
    scores = [one for one in found if one is not None]
    means = {
        name: float(np.mean([getattr(one, name) for one in scores]))
        for name in ("hota", "assa", "idf1")
        if scores and getattr(scores[0], name) is not None
    }
    sums = {
        name: sum(getattr(one, name) or 0 for one in scores)
        for name in ("switches", "misses", "false_names", "images")
    }
    return {"scene": scene.words, "flights": len(scores), **means, **sums}


def markdown(rows: list[dict[str, object]]) -> str:
    """Return the table."""
    lines = [
        "| scene | flights | IDF1 | HOTA | AssA | switches | misses | false | images |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for one in rows:
        scores = " | ".join(f"{one.get(key, float('nan')):.3f}" for key in ("idf1", "hota", "assa"))
        counts = " | ".join(str(one[k]) for k in ("switches", "misses", "false_names", "images"))
        lines.append(f"| {one['scene']} | {one['flights']} | {scores} | {counts} |")
    return "\n".join(lines) + "\n"


def main() -> int:
    """Fly all scenes and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="flights a scene")
    parser.add_argument("--only", default="", help="scenes whose words hold this")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--markdown", type=Path)
    given = parser.parse_args()
    rows = []
    for scene in SCENES:
        if given.only in scene.words:
            rows.append(row(scene, [measure(scene, seed) for seed in range(given.seeds)]))
            print(markdown(rows).splitlines()[-1], file=sys.stderr, flush=True)
    print(markdown(rows))
    if given.markdown:
        given.markdown.write_text(markdown(rows), encoding="utf-8")
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
