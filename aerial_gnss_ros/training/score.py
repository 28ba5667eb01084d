# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scores any detector on labelled frames: precision, recall and centre error, by size.

python -m aerial_gnss_ros.training.score MODEL FOLDER
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import sys
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import AerialGnssError
from aerial_gnss_ros.detection.base import Detections, Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.detection.yolo import iou
from aerial_gnss_ros.text.sentences import counted
from aerial_gnss_ros.training.labelled import LabelledImage, Truth, read_folder
from aerial_gnss_ros.training.labelled_bag import is_bag, read_bag

MATCH_IOU = 0.5
SIZES_PX = (0.0, 16.0, 24.0, 40.0, 80.0, 160.0, float("inf"))
THRESHOLDS = tuple(round(0.05 * i, 2) for i in range(3, 17))
CONTRASTS = (0.0, 0.05, 0.1, 0.2, float("inf"))


@dataclass(frozen=True)
class Match:
    """Assignment of one image's boxes to robots.

    Attributes:
        robot: (n boxes,) index of the detected robot; -1: none; -2: a robot that does not count.
        box: (n robots,) index of its box, -1 if it was missed.
    """

    robot: NDArray[np.int64]
    box: NDArray[np.int64]


def match(found: Detections, truth: Truth, least_iou: float = MATCH_IOU) -> Match:
    """Return the assignment of boxes to robots: best score first, least IoU, equal class.

    A box without a robot that counts, but with its centre in one that does not (too small, too
    faint, truncated), is neither right nor wrong.
    """
    corners = found.xyxy
    overlap = iou(corners, truth.corners) * (found.class_ids[:, None] == truth.class_ids[None, :])
    robot = np.full(len(found), -1, dtype=np.int64)
    box = np.full(len(truth.corners), -1, dtype=np.int64)
    for i in np.argsort(-found.scores, kind="stable"):
        for mask, is_counted in ((truth.counted, True), (~truth.counted, False)):
            free = np.where(mask & (box < 0), overlap[i], 0.0)
            j = int(free.argmax()) if free.size else -1
            if j >= 0 and free[j] >= least_iou:
                robot[i], box[j] = (j if is_counted else -2), i
                break
        else:
            if _inside(found.xywh[i, :2], truth.corners[~truth.counted]):
                robot[i] = -2
    return Match(robot, box)


def _inside(point: NDArray[np.float64], corners: NDArray[np.float64]) -> bool:
    return bool(((point >= corners[:, :2]) & (point <= corners[:, 2:])).all(axis=1).any())


@dataclass
class Tally:
    """Robots and boxes counted."""

    robots: int = 0
    found: int = 0
    false: int = 0

    @property
    def recall(self) -> float:
        """Share of the robots that were detected."""
        return self.found / self.robots if self.robots else float("nan")

    @property
    def precision(self) -> float:
        """Share of the boxes that are robots."""
        boxes = self.found + self.false
        return self.found / boxes if boxes else float("nan")


@dataclass
class Score:
    """All counts over a set of images.

    Attributes:
        overall: robots that count, and boxes.
        by_size: by the robot's long side (false boxes: by their own), including sizes that do not
            count; robots too faint or truncated are left out.
        by_contrast: the same by contrast, of robots large enough; without false boxes.
        centre_error_px: distance of box centres from the truth, of detected robots that count.
        offset_px: (u, v) box centre less truth, the same robots.
        images: how many.
    """

    overall: Tally = field(default_factory=Tally)
    by_size: list[Tally] = field(default_factory=lambda: [Tally() for _ in SIZES_PX[1:]])
    by_contrast: list[Tally] = field(default_factory=lambda: [Tally() for _ in CONTRASTS[1:]])
    centre_error_px: list[float] = field(default_factory=list)
    offset_px: list[tuple[float, float]] = field(default_factory=list)
    images: int = 0

    def add(self, found: Detections, truth: Truth, least_iou: float = MATCH_IOU) -> Match:
        """Count one image."""
        matched = match(found, truth, least_iou)
        self.images += 1
        false = matched.robot == -1
        self.overall.robots += int(truth.counted.sum())
        self.overall.found += int((matched.robot >= 0).sum())
        self.overall.false += int(false.sum())
        for long_px in found.xywh[false, 2:].max(axis=1, initial=0.0):
            self.by_size[_bin(SIZES_PX, long_px)].false += 1
        for j, box in enumerate(matched.box):
            small = truth.long_px[j] < SIZES_PX[1]
            faint = truth.contrast[j] < CONTRASTS[1]
            if truth.counted[j] or (small and not faint):
                _count(self.by_size[_bin(SIZES_PX, truth.long_px[j])], box >= 0)
            if np.isfinite(truth.contrast[j]) and (truth.counted[j] or (faint and not small)):
                _count(self.by_contrast[_bin(CONTRASTS, truth.contrast[j])], box >= 0)
            if truth.counted[j] and box >= 0:
                middle = (truth.corners[j, :2] + truth.corners[j, 2:]) / 2
                u, v = found.xywh[box, :2] - middle
                self.offset_px.append((float(u), float(v)))
                self.centre_error_px.append(float(np.hypot(u, v)))
        return matched

    def as_dict(self) -> dict[str, Any]:
        """Return the figures for JSON."""
        errors = self.centre_error_px or [float("nan")]
        return {
            "images": self.images,
            "precision": self.overall.precision,
            "recall": self.overall.recall,
            "overall": asdict(self.overall),
            "centre_error_median_px": float(np.median(errors)),
            "centre_error_p95_px": float(np.percentile(errors, 95)),
            "centre_offset_px": [
                float(x) for x in np.mean(self.offset_px or [(float("nan"), float("nan"))], axis=0)
            ],
            "by_long_side_px": _table(SIZES_PX, self.by_size),
            "by_contrast": _table(CONTRASTS, self.by_contrast),
        }


def _bin(edges: tuple[float, ...], value: float) -> int:
    return int(np.clip(np.searchsorted(edges, value, side="right") - 1, 0, len(edges) - 2))


def _count(tally: Tally, found: bool) -> None:
    tally.robots += 1
    tally.found += int(found)


def _table(edges: tuple[float, ...], tallies: list[Tally]) -> dict[str, dict[str, int]]:
    names = [
        f"{low:g} or more" if math.isinf(high) else f"{low:g} to {high:g}"
        for low, high in itertools.pairwise(edges)
    ]
    return {name: asdict(tally) for name, tally in zip(names, tallies, strict=True)}


def score(detector: Detector, images: Iterable[LabelledImage]) -> Score:
    """Return the scores of `detector` on `images`."""
    result = Score()
    for image in images:
        result.add(detector.detect(image.read()), image.truth)
    return result


def sweep(detector: Detector, images: Iterable[LabelledImage]) -> dict[float, Score]:
    """Return the scores at each of `THRESHOLDS`, for choosing one.

    Args:
        detector: with a score threshold of the first of them or less.
        images: others than those for testing the choice.
    """
    results = {threshold: Score() for threshold in THRESHOLDS}
    for image in images:
        found = detector.detect(image.read())
        for threshold, result in results.items():
            result.add(above(found, threshold), image.truth)
    return results


def above(found: Detections, threshold: float) -> Detections:
    """Return the boxes that a detector with this score threshold would report."""
    kept = found.scores >= threshold
    return Detections(
        found.xywh[kept], found.scores[kept], found.class_ids[kept], found.class_names
    )


def score_above(pairs: Iterable[tuple[Detections, Truth]], threshold: float) -> Score:
    """Return the scores of boxes above a threshold on their images."""
    result = Score()
    for found, truth in pairs:
        result.add(above(found, threshold), truth)
    return result


def sweep_report(results: dict[float, Score]) -> str:
    """Return precision, recall and their harmonic mean at each threshold as text."""
    lines = ["| score | precision | recall | F1 |", "|---|---|---|---|"]
    for threshold, result in results.items():
        p, r = result.overall.precision, result.overall.recall
        lines.append(f"| {threshold:.2f} | {p:.3f} | {r:.3f} | {2 * p * r / (p + r):.3f} |")
    return "\n".join(lines) + "\n"


def report(result: Score) -> str:
    """Return the figures as text."""
    figures, overall = result.as_dict(), result.overall
    median, p95 = figures["centre_error_median_px"], figures["centre_error_p95_px"]
    u, v = figures["centre_offset_px"]
    missed = overall.robots - overall.found
    images, robots = counted(result.images, "image"), counted(overall.robots, "robot")
    lines = [
        f"{images}, {robots} that count, at IoU {MATCH_IOU}",
        f"precision {overall.precision:.3f}, recall {overall.recall:.3f}",
        f"{overall.found} found, {missed} missed, {counted(overall.false, 'false box')}",
        f"box centre: error median {median:.2f}, p95 {p95:.2f}, mean offset {u:+.2f} {v:+.2f} px",
        "",
        "| long side, px | robots | found | recall | false boxes |",
        "|---|---|---|---|---|",
    ]
    notes = [" (not counted)", *[""] * max(len(SIZES_PX), len(CONTRASTS))]
    for name, note, size in zip(figures["by_long_side_px"], notes, result.by_size, strict=False):
        counts = f"{size.robots} | {size.found} | {size.recall:.3f} | {size.false}"
        lines.append(f"| {name}{note} | {counts} |")
    lines += ["", "| contrast | robots | found | recall |", "|---|---|---|---|"]
    for name, note, tally in zip(figures["by_contrast"], notes, result.by_contrast, strict=False):
        lines.append(f"| {name}{note} | {tally.robots} | {tally.found} | {tally.recall:.3f} |")
    return "\n".join(lines) + "\n"


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line; returns the exit status."""
    default = DetectorConfig()
    parser = argparse.ArgumentParser(prog="score", description=__doc__)
    parser.add_argument("model", help="path of a model, or the name of a shipped one")
    parser.add_argument(
        "folder", type=Path, help="labelled images in YOLO's layout, or a simulated bag"
    )
    parser.add_argument("--split", default="test", help="folder below images/ (default test)")
    parser.add_argument("--backend", default=default.backend)
    parser.add_argument("--score-threshold", type=float, default=default.score_threshold)
    parser.add_argument("--image-size", type=int, default=default.image_size)
    parser.add_argument("--second-look", default=default.second_look, metavar="auto|off|FILE")
    parser.add_argument("--allow-pickle", action="store_true", help="trust a .pt file")
    parser.add_argument("--sweep", action="store_true", help="precision and recall by threshold")
    parser.add_argument("--json", action="store_true", help="figures as JSON")
    given = parser.parse_args(arguments)
    config = DetectorConfig(
        model=given.model,
        backend=given.backend,
        score_threshold=THRESHOLDS[0] if given.sweep else given.score_threshold,
        image_size=given.image_size,
        second_look=given.second_look,
        allow_pickle=given.allow_pickle,
    )
    try:
        if is_bag(given.folder):
            images = read_bag(given.folder)
        else:
            images = read_folder(given.folder, given.split)
        if given.sweep:
            sys.stdout.write(sweep_report(sweep(load_detector(config), images)))
            return 0
        result = score(load_detector(config), images)
    except AerialGnssError as error:
        sys.stderr.write(f"score: {error}\n")
        return 2
    sys.stdout.write(json.dumps(result.as_dict(), indent=2) if given.json else report(result))
    return 0


if __name__ == "__main__":
    sys.exit(main())
