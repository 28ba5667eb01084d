# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scores several models on the same images, relative to the first."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from aerial_gnss_ros.detection.base import Detections, Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.training.average_precision import LOWEST_SCORE, average_precision
from aerial_gnss_ros.training.labelled import LabelledImage, Truth, read_folder
from aerial_gnss_ros.training.labelled_bag import is_bag, read_bag
from aerial_gnss_ros.training.score import score_above


@dataclass(frozen=True)
class Figures:
    """Scores of one model.

    Attributes:
        name: of the detector.
        images: how many.
        map50: mean average precision at IoU 0.5, 0 to 1.
        map50_95: the same over IoU 0.5 to 0.95.
        precision: at IoU 0.5 and the default score threshold.
        recall: the same.
        centre_error_median_px: of the boxes found, against the truth.
        centre_shift_p95_px: 95th percentile of the distance from the first model's boxes to this
            model's.
    """

    name: str
    images: int
    map50: float
    map50_95: float
    precision: float
    recall: float
    centre_error_median_px: float
    centre_shift_p95_px: float


def labelled(path: Path, split: str) -> Iterable[LabelledImage]:
    """Return the labelled images of a folder in YOLO's layout, or of a simulated bag."""
    return read_bag(path) if is_bag(path) else read_folder(path, split)


def images_of(folders: Iterable[Path]) -> Iterator[LabelledImage]:
    """Yield the labelled images of folders, of the first split that has any, and of flights."""
    for folder in folders:
        splits = ("train", "test", "val")
        split = next((s for s in splits if any((folder / "images" / s).glob("*"))), "train")
        yield from labelled(folder, split)


def compare(
    detectors: Sequence[Detector],
    images: Iterable[LabelledImage],
    report: Callable[[int], None] = lambda _: None,
) -> list[Figures]:
    """Return the figures of each detector; shifts are relative to the first.

    Args:
        detectors: with a score threshold of `LOWEST_SCORE`.
        images: each is read once for all.
        report: called with the number of images done.
    """
    seen: list[list[tuple[Detections, Truth]]] = [[] for _ in detectors]
    for number, image in enumerate(images, start=1):
        pixels = image.read()
        for detector, pairs in zip(detectors, seen, strict=True):
            pairs.append((detector.detect(pixels), image.truth))
        report(number)
    return [
        _figures(detector, pairs, seen[0]) for detector, pairs in zip(detectors, seen, strict=True)
    ]


def _figures(
    detector: Detector,
    pairs: list[tuple[Detections, Truth]],
    reference: list[tuple[Detections, Truth]],
) -> Figures:
    threshold = DetectorConfig().score_threshold
    score, shifts = score_above(pairs, threshold), [0.0]
    for (found, _), (first, _) in zip(pairs, reference, strict=True):
        if len(found):
            away = first.xywh[first.scores >= threshold, None, :2] - found.xywh[None, :, :2]
            shifts += np.hypot(away[..., 0], away[..., 1]).min(axis=1).tolist()
    whole = average_precision(pairs)
    return Figures(
        detector.name,
        len(pairs),
        whole.map50,
        whole.map50_95,
        score.overall.precision,
        score.overall.recall,
        float(np.median(score.centre_error_px or [float("nan")])),
        float(np.percentile(shifts, 95)),
    )


def for_scoring(config: DetectorConfig) -> DetectorConfig:
    """Return a configuration that reports all boxes of a model alone, however low their scores."""
    return replace(config, score_threshold=LOWEST_SCORE, second_look="off")


def table(figures: Sequence[Figures]) -> str:
    """Return the figures as a Markdown table, with losses relative to the first."""
    lines = [
        "| model | mAP50-95 | mAP50 | precision | recall | centre error, px | shift p95, px |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in figures:
        ap = [
            f"{100 * value:.2f} ({100 * (value - first):+.2f})"
            for value, first in (
                (row.map50_95, figures[0].map50_95),
                (row.map50, figures[0].map50),
            )
        ]
        lines.append(
            f"| {row.name} | {ap[0]} | {ap[1]} | {row.precision:.3f} | {row.recall:.3f} | "
            f"{row.centre_error_median_px:.2f} | {row.centre_shift_p95_px:.2f} |"
        )
    return "\n".join(lines) + "\n"
