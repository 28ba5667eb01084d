# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How alike a detector's scores of one thing are, and what `tracks.confirm_score` makes of them.

    python benchmarks/lasting_scores.py REAL_WATER -o WORK --flights FLIGHT ...

WORK is that of `unseen_water.py`: the detector's second look has not seen the video. Its labelled
things are linked from image to image by the image's motion, without any tracker. Robots are those
of simulated flights with images. A thing is confirmed as the tracker would, with three boxes from
the score threshold on; `min_score` stands for no condition.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from tables import columns, show
from unseen_water import finished
from unseen_water_images import Seen, images_of, photographs, seen_of
from unseen_water_tables import above

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.core.tracker.score_evidence import log_odds, scores_as_robots
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.detection.yolo import iou
from aerial_gnss_ros.teaching.alignment import align, small
from aerial_gnss_ros.teaching.proposals import Proposer
from aerial_gnss_ros.text.json_text import parse_json
from aerial_gnss_ros.training.picture_labels import PictureLabels
from aerial_gnss_ros.training.share import Share

Array = NDArray[np.float64]
VIDEO, INTERVAL_S = "northsea_video", 0.5
KINDS = ("swimmer",)
NEAR_PX, KEPT, ON = 70.0, 4, 0.1
"""Distance within which a moved label fits; images for which a missing one is kept; IoU."""
LEAST = (0.0, 0.4, 0.5, 0.55, 0.6, 0.7)
BOXES = 3


@dataclass
class Thing:
    """One thing: seconds and scores of its boxes, and the number of images that show it."""

    boxes: list[tuple[float, float]] = field(default_factory=list)
    images: int = 0

    def add(self, t: float, fits: Array, found: Detections) -> None:
        """Add an image that shows it, with the box that fits it best, if one does."""
        self.images += 1
        on = np.flatnonzero(fits > ON)
        if len(on):
            self.boxes.append((t, float(found.scores[on].max())))

    def confirmed(self, least: float) -> bool:
        """Return whether it would be a robot at some time."""
        odds = np.cumsum([log_odds(score) for _, score in self.boxes])
        begun = self.boxes[0][0] if self.boxes else 0.0
        return any(
            scores_as_robots(float(odds[n - 1]), n, self.boxes[n - 1][0] - begun, least)
            for n in range(BOXES, len(self.boxes) + 1)
        )


def video(given: argparse.Namespace) -> list[Thing]:
    """Return the labelled things of the video."""
    folder: Path = given.real / VIDEO
    labels = PictureLabels(folder / "labels.csv", ())
    seen = seen_of(given, f"plain_{VIDEO}", photographs(folder))
    file = given.output / f"without_{VIDEO}.onnx"
    share = Share(**json.loads(file.with_suffix(".json").read_text()))
    by_name = {
        name: above(found, DetectorConfig.score_threshold)
        for name, found, _ in finished(seen, file, share, given.threads)
    }
    things: dict[int, Thing] = defaultdict(Thing)
    for number, (name, corners, keys) in enumerate(linked(folder, sorted(by_name), labels)):
        found = by_name[name]
        fits = iou(found.xyxy, corners)
        for column, key in enumerate(keys):
            things[key].add(number * INTERVAL_S, fits[:, column], found)
    return list(things.values())


def linked(
    folder: Path, names: Sequence[str], labels: PictureLabels
) -> Iterator[tuple[str, Array, list[int]]]:
    """Yield name, labelled boxes and the thing of each, for each image of a video."""
    proposer, before, count = Proposer(), None, 0
    places: dict[int, tuple[Array, int]] = {}
    for number, name in enumerate(names):
        image = read_image(folder / "images" / name)
        now = proposer.propose(image), small(image)
        if before is not None:
            motion = align(before[0], now[0], image.shape[1], (before[1], now[1]))
            places = {
                key: (motion.move(at[None])[0], last)
                for key, (at, last) in places.items()
                if number - last <= KEPT
            }
        before = now
        known = labels.of(name, (0, 0))
        chosen = [i for i, kind in enumerate(known.classes if known else ()) if kind in KINDS]
        corners = known.corners[chosen] if known else np.zeros((0, 4))
        middles = 0.5 * (corners[:, :2] + corners[:, 2:])
        keys = matched(places, middles)
        for i, middle in enumerate(middles):
            if keys[i] < 0:
                keys[i], count = count, count + 1
            places[keys[i]] = (middle, number)
        yield name, corners, keys


def matched(places: dict[int, tuple[Array, int]], middles: Array) -> list[int]:
    """Return the thing at each of `middles` (n, 2); -1 where none is."""
    keys, found = list(places), [-1] * len(middles)
    if keys and len(middles):
        at = np.array([places[key][0] for key in keys])
        away = np.linalg.norm(at[:, None] - middles[None], axis=2)
        for row, column in zip(*linear_sum_assignment(np.minimum(away, NEAR_PX)), strict=True):
            if away[row, column] < NEAR_PX:
                found[column] = keys[row]
    return found


def robots(given: argparse.Namespace) -> list[Thing]:
    """Return the robots of the flights that are shown clearly by three images or more."""
    file = given.output / f"without_{VIDEO}.onnx"
    share = Share(**json.loads(file.with_suffix(".json").read_text()))
    things: dict[tuple[Path, str], Thing] = defaultdict(Thing)
    for flight in given.flights:
        seen: list[Seen] = seen_of(given, flight.name, images_of(flight))
        names = names_of(flight)
        for name, every, truth in finished(seen, file, share, given.threads):
            found, stamp_ns = above(every, DetectorConfig.score_threshold), int(name.split()[-1])
            fits = iou(found.xyxy, truth.corners)
            for i in np.flatnonzero(truth.counted):
                key = flight, names[stamp_ns][i]
                things[key].add(stamp_ns * 1e-9, fits[:, i], found)
    return [thing for thing in things.values() if thing.images >= BOXES]


def names_of(flight: Path) -> dict[int, list[str]]:
    """Return the robots in the labels of each image, by stamp, ns."""
    with open_bag([flight]) as bag:
        topics = {name for name in bag.topics if name.endswith("truth/labels")}
        texts = [str(one.message().data) for one in bag.messages(topics)]
    return {
        int(about["stamp_ns"]): [str(row["robot_id"]) for row in about["robots"]]
        for about in map(parse_json, texts)
    }


def spreads(things: Sequence[Thing]) -> str:
    """Return the spread of the log odds within things and between them, and their correlation."""
    rows = [np.array([log_odds(s) for _, s in one.boxes]) for one in things if len(one.boxes) > 2]
    apart = [row - row.mean() for row in rows]
    within = np.concatenate(apart)
    pairs = np.concatenate([row[1:] * row[:-1] for row in apart])
    means = [row.mean() for row in rows]
    return (
        f"log odds {np.mean(means):.2f} in the mean, spread {np.std(means):.2f} between, "
        f"{within.std():.2f} within, successive ones correlated by "
        f"{pairs.mean() / within.var():.2f}"
    )


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("real", type=Path, metavar="REAL_WATER")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="WORK")
    parser.add_argument("--flights", type=Path, nargs="+", default=[], metavar="FLIGHT")
    parser.add_argument("--model", default=DetectorConfig.model)
    parser.add_argument("--threads", type=int, default=1)
    given = parser.parse_args()
    kinds = {"swimmers": video(given), "robots": robots(given)}
    for name, things in kinds.items():
        sys.stdout.write(f"{len(things)} {name}: {spreads(things)}\n")
    rows = [
        [f"{least:g}", *(f"{sum(t.confirmed(least) for t in every)} of {len(every)}"
                         for every in kinds.values())]
        for least in LEAST
    ]  # fmt: skip
    show(columns(["tracks.confirm_score", *(f"{name} confirmed" for name in kinds)], rows), None)


if __name__ == "__main__":
    main()
