# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What `model: anomaly` and geometry make of simulated flights over photographs of water.

python benchmarks/anomaly_flights.py REAL_WATER/lake_nadir --photographs 12

Each flight is over three swimming hexapods (0.65 m) and another photograph, of which only the part
without anything labelled lies on the water; RTK, 1280x720. The estimator is told lengths of 0.4 to
0.9 m. What a photograph shows stays in one place of the water for the whole flight, unlike real
foam and glint, so that those which look like robots become more false robots than at sea. A robot
has a position in an image if there is one within 2 m; a false robot is a name whose first position
is farther than that from every robot.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import ORIGIN, Image, results
from numpy.typing import NDArray
from tables import columns, show

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.detection.anomaly import AnomalyDetector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.simulation.boxes import Boxes
from aerial_gnss_ros.simulation.experiment import (
    CAMERA_FRAME,
    CameraClock,
    Experiment,
    default_camera,
)
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.scene import demo_scene
from aerial_gnss_ros.simulation.sensors import sensor_plan
from aerial_gnss_ros.simulation.water_photograph import WaterPhotograph, WaterRenderer
from aerial_gnss_ros.training.picture_labels import PictureLabels

FALSE_M, NEAR_PX, WIDTH_M, LEAST_PX = 2.0, 12.0, 30.0, 400
FLIGHTS = (("orbit", 12.0), ("hover", 10.0), ("transit", 15.0))
HEADS = ["score_threshold", "false boxes an image", "robots' images with a position",
         "robots found", "false robots", "a minute", "photographs without any"]  # fmt: skip


def main() -> None:
    """Fly, and print a table that grows."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", type=Path, help="with images/ and labels.csv")
    parser.add_argument("--photographs", type=int, default=12)
    parser.add_argument("--duration", type=float, default=50.0, help="of a flight, s")
    parser.add_argument("--rate", type=float, default=3.0, help="images a second")
    parser.add_argument("--score", type=float, nargs="+", default=[0.3, 0.4, 0.7])
    parser.add_argument("--seed", type=int, default=9100)
    parser.add_argument("--only", nargs="+", metavar="NAME", help="of the photographs, these only")
    parser.add_argument("--markdown", type=Path, metavar="PAGE")
    args = parser.parse_args()
    files = sorted((args.source / "images").glob("*.jpg"))
    labels = PictureLabels(args.source / "labels.csv", ())
    every: dict[float, list[NDArray[np.float64]]] = {score: [] for score in args.score}
    chosen = np.unique(np.linspace(0, len(files) - 1, args.photographs).round().astype(int))
    for number, file in enumerate(files[i] for i in chosen):
        if args.only and file.stem not in args.only:
            continue
        part = _free(read_image(file), labels.of(file.name, (0, 0)))
        if part is None:
            continue
        kind, height = FLIGHTS[number % len(FLIGHTS)]
        for score, counts in _fly(args, part, kind, height, args.seed + number):
            every[score].append(counts)
            row = _row(score, [counts], args.rate)
            print(" | ".join([file.stem, f"{kind} {height:g} m", *row]), flush=True)
    show(columns(HEADS, [_row(*one, args.rate) for one in every.items()]), args.markdown)


def _row(score: float, flights: list[NDArray[np.float64]], rate: float) -> list[str]:
    images, false_boxes, seen, have, robots, found, false = np.sum(flights, axis=0)
    clean = sum(not one[-1] for one in flights)
    return [
        f"{score:g}", f"{false_boxes / images:.2f}", f"{100.0 * have / max(seen, 1):.0f} %",
        f"{found:.0f} of {robots:.0f}", f"{false:.0f}", f"{false / (images / rate / 60.0):.2f}",
        f"{clean} of {len(flights)}",
    ]  # fmt: skip


def _free(image: NDArray[np.uint8], labels: object) -> NDArray[np.uint8] | None:
    """Return the largest part of a photograph without anything labelled; None: all are small."""
    height, width = image.shape[:2]
    corners = labels.corners if labels is not None else np.zeros((0, 4))
    edges_x, edges_y = np.linspace(0, width, 13).astype(int), np.linspace(0, height, 10).astype(int)
    best, largest = None, 0
    for x0 in edges_x:
        for x1 in edges_x[edges_x - x0 >= LEAST_PX]:
            for y0 in edges_y:
                for y1 in edges_y[edges_y - y0 >= LEAST_PX]:
                    apart = (
                        (corners[:, 2] + 8 < x0) | (corners[:, 0] - 8 > x1)
                        | (corners[:, 3] + 8 < y0) | (corners[:, 1] - 8 > y1)
                    )  # fmt: skip
                    if apart.all() and (x1 - x0) * (y1 - y0) > largest:
                        largest, best = (x1 - x0) * (y1 - y0), image[y0:y1, x0:x1]
    return None if best is None else np.ascontiguousarray(best)


def _fly(
    args: argparse.Namespace, part: NDArray[np.uint8], kind: str, height: float, seed: int
) -> Iterator[tuple[float, NDArray[np.float64]]]:
    """Yield for each threshold what `_counts` returns.

    The detector's boxes at a higher threshold are those of a lower one that score as high.
    """
    plan = FlightPlan(kind=kind, duration_s=args.duration, height_m=height, speed_mps=3.0)
    made = Experiment(
        GeneratedFlight(plan, seed), default_camera(1280, 720),
        sensor_plan("consumer", gnss_offset_m=0.02), CameraClock(rate_hz=args.rate), robots=3,
        swim=SwimPlan(), seed=seed,
    )  # fmt: skip
    # The scale of the whole photograph, so that waves are as large in every part of it.
    water = WaterPhotograph(part, WIDTH_M * part.shape[1] / 1230.0)
    renderer = WaterRenderer(demo_scene(seed), water)
    detector = AnomalyDetector(DetectorConfig(model="anomaly", score_threshold=min(args.score)))
    images: list[Image] = []
    for frame in made.frames():
        image, labels = renderer.render(made.camera, frame.pose, frame.t, made.states(frame))
        clear = [one for one in labels if one.clear]
        xywh = np.array([one.xywh for one in clear]).reshape(-1, 4)
        names = tuple(one.robot_id for one in clear)
        found = detector.detect(image)
        images.append((
            frame,
            Boxes(names, ("object",) * len(clear), xywh[:, :2], xywh[:, 2:]),
            DetectionFrame(frame.stamp_ns, CAMERA_FRAME, found.xywh[:, :2], found.xywh[:, 2:],
                           found.scores, found.names),
        ))  # fmt: skip
    config = estimator_config({
        "map.latitude_deg": math.degrees(ORIGIN.latitude),
        "map.longitude_deg": math.degrees(ORIGIN.longitude),
        "fix.altitude_datum": "ellipsoid", "noise.gnss_offset_m": 0.02,
        "classes.object.length_m": [0.4, 0.9],
    })  # fmt: skip
    for score in args.score:
        kept = [(frame, boxes, seen.keep(seen.scores >= score)) for frame, boxes, seen in images]
        yield score, _counts(made, kept, results(made, config, kept))


def _counts(made: Experiment, images: list[Image], found: list) -> NDArray[np.float64]:
    """Return images, false boxes, robots' images, those with a position, robots, found, false."""
    false_boxes = seen = have = 0
    by_stamp = {frame.stamp_ns: (frame, boxes) for frame, boxes, _ in images}
    for _, boxes, detected in images:
        away = np.linalg.norm(detected.centers[:, None] - boxes.centers[None], axis=2)
        reach = np.maximum(NEAR_PX, boxes.sizes.max(axis=1, initial=0.0)) if len(boxes.names) else 0
        false_boxes += int((~(away < reach).any(axis=1)).sum())
        seen += len(boxes.names)
    first: dict[str, bool] = {}
    robots = {name for _, boxes, _ in images for name in boxes.names}
    tracked: set[str] = set()
    for result in found:
        frame, boxes = by_stamp[result.stamp_ns]
        places = made.swarm.positions(np.array([frame.t]))[:, 0, :2]
        spots = np.array([one.position for one in result.estimates]).reshape(-1, 2)
        apart = np.linalg.norm(places[:, None] - spots[None], axis=2)
        for column, one in enumerate(result.estimates):
            first.setdefault(one.robot_id, bool(apart[:, column].min() < FALSE_M))
        near = (apart < FALSE_M).any(axis=1) if len(spots) else np.zeros(len(places), bool)
        for name, one in zip(made.swarm.names, near, strict=True):
            if name in boxes.names and one:
                have += 1
                tracked.add(name)
    false = sum(not good for good in first.values())
    return np.array([len(images), false_boxes, seen, have, len(robots), len(tracked), false], float)


if __name__ == "__main__":
    main()
