# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cuts small training tiles around a network's errors, and some others (hard-example mining).

python -m aerial_gnss_ros.training.mining MODEL FOLDER ... -o TILES

A trained network learns nothing more from most of an image of the sea. A tile of 160 px costs a
quarter of a crop of 320 px, and contains what is worth learning.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import AerialGnssError, ConfigError, OutputError
from aerial_gnss_ros.detection.base import Detections, Detector, Image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.images import write_jpeg
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.detection.yolo import iou
from aerial_gnss_ros.training.labelled import LabelledImage, Truth, read_labels
from aerial_gnss_ros.training.labelled_bag import is_bag, read_bag
from aerial_gnss_ros.training.score import match

Corners = NDArray[np.float64]
_LOOKED_AT = 0.1  # boxes of lower score are ignored
_QUALITY = 95
_PLACINGS = 12


@dataclass(frozen=True)
class Mining:
    """Selection of tiles.

    Attributes:
        side: of a tile, px.
        false_score: a box on no robot counts as an error from this score on.
        true_score: a robot detected with a lower score is hard.
        least_iou: a robot detected with a lower IoU is hard.
        draws: randomly placed tiles around every hard position.
        easy: tiles from other positions per image.
        seed: of the placing.
    """

    side: int = 160
    false_score: float = 0.15
    true_score: float = 0.6
    least_iou: float = 0.75
    draws: int = 2
    easy: float = 0.5
    seed: int = 0


def mine(
    detector: Detector, images: Iterable[LabelledImage], folder: Path, mining: Mining
) -> tuple[int, int]:
    """Write tiles to the new `folder` in YOLO's layout, split train.

    Args:
        detector: set to a score threshold below `false_score`.
        images: to cut from; at least as large as a tile.
        folder: created when everything is written.
        mining: selection of tiles.

    Returns:
        Number of hard and of other tiles.

    Raises:
        OutputError: the folder exists.
        ConfigError: an image is smaller than a tile.
    """
    if folder.exists():
        raise OutputError(f"the folder {folder} exists already; give a new one.")
    partial = folder.with_name(f".{folder.name}.partial")
    shutil.rmtree(partial, ignore_errors=True)
    for kind in ("images", "labels"):
        (partial / kind / "train").mkdir(parents=True)
    rng = np.random.default_rng(mining.seed)
    hard = easy = 0
    try:
        for labelled in images:
            image = labelled.read()
            if min(image.shape[:2]) < mining.side:
                raise ConfigError(
                    f"{labelled.name} is {image.shape[1]}x{image.shape[0]} px, smaller than a tile "
                    f"of {mining.side} px."
                )
            boxes = labelled.truth
            places = np.repeat(
                hard_places(detector.detect(image), boxes, mining), mining.draws, axis=0
            )
            others = _other_places(rng, image, boxes, int(rng.poisson(mining.easy)))
            for place in np.vstack([places, others]):
                window = _window(rng, place, boxes.corners, image, mining.side)
                name = f"{Path(labelled.name).stem}_{hard + easy:06d}"
                _write(partial, name, image, boxes, window, mining.side)
                hard, easy = hard + (len(places) > 0), easy + (len(places) == 0)
                places = places[1:]
        names = "".join(f"  {i}: {name}\n" for i, name in enumerate(detector.class_names))
        text = f"train: images/train\nval: images/train\nnames:\n{names}"
        (partial / "data.yaml").write_text(text, encoding="utf-8")
        partial.rename(folder)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    return hard, easy


def hard_places(found: Detections, truth: Truth, mining: Mining) -> Corners:
    """Return the centres (n, 2) of false boxes, and of robots missed or nearly missed, px."""
    matched = match(found, truth)
    places = [found.xywh[i, :2] for i in np.flatnonzero(matched.robot == -1)
              if found.scores[i] >= mining.false_score]  # fmt: skip
    fits = iou(found.xyxy, truth.corners)
    for j in np.flatnonzero(truth.counted):
        i = matched.box[j]
        if i < 0 or found.scores[i] < mining.true_score or fits[i, j] < mining.least_iou:
            places.append((truth.corners[j, :2] + truth.corners[j, 2:]) / 2)
    return np.array(places, dtype=np.float64).reshape(-1, 2)


def _other_places(rng: np.random.Generator, image: Image, truth: Truth, count: int) -> Corners:
    """Return positions (count, 2) of robots as far as there are any, else random ones."""
    size = np.array([image.shape[1], image.shape[0]], dtype=np.float64)
    places = rng.uniform((0.0, 0.0), size, (count, 2))
    if len(truth.corners):
        middles = (truth.corners[:, :2] + truth.corners[:, 2:]) / 2
        chosen = rng.random(count) < 0.7
        places[chosen] = middles[rng.integers(len(middles), size=int(chosen.sum()))]
    return places


def _window(
    rng: np.random.Generator, place: Corners, corners: Corners, image: Image, side: int
) -> NDArray[np.int64]:
    """Return left and top of a tile that contains the position and cuts few robots."""
    room = np.array([image.shape[1], image.shape[0]]) - side
    best, least = np.zeros(2, dtype=np.int64), np.inf
    for _ in range(_PLACINGS):
        left_top = np.clip(np.round(place - rng.uniform(0.2, 0.8, 2) * side), 0, room)
        shares = _shares(corners, left_top, side)
        cut = float((shares * (1.0 - shares)).sum())
        if cut < least:
            best, least = left_top.astype(np.int64), cut
        if not cut:
            break
    return best


def _shares(corners: Corners, left_top: NDArray[np.generic], side: int) -> NDArray[np.float64]:
    """Return how much of each box (n, 4) is in the tile."""
    kept = _clipped(corners, left_top, side)
    area = np.prod(np.maximum(kept[:, 2:] - kept[:, :2], 0.0), axis=1)
    whole = np.prod(np.maximum(corners[:, 2:] - corners[:, :2], 1e-9), axis=1)
    return np.asarray(area / whole, dtype=np.float64)


def _clipped(corners: Corners, left_top: NDArray[np.generic], side: int) -> Corners:
    moved = corners - np.tile(left_top, 2).astype(np.float64)
    return np.clip(moved, -0.5, side - 0.5)


def _write(
    folder: Path, name: str, image: Image, truth: Truth, left_top: NDArray[np.int64], side: int
) -> None:
    x, y = int(left_top[0]), int(left_top[1])
    tile = image[y : y + side, x : x + side]
    path = folder / "images" / "train" / f"{name}.jpg"
    write_jpeg(path, tile, _QUALITY)
    lines = []
    shares = _shares(truth.corners, left_top, side)
    for box, share, number in zip(
        _clipped(truth.corners, left_top, side), shares, truth.class_ids, strict=True
    ):
        if share >= 0.4:  # as a crop of the simulation is labelled
            middle, size = (box[:2] + box[2:]) / 2 + 0.5, box[2:] - box[:2]
            lines.append(" ".join([str(number), *(f"{v / side:.6f}" for v in (*middle, *size))]))
    text = folder / "labels" / "train" / f"{name}.txt"
    text.write_text("".join(f"{line}\n" for line in lines), encoding="ascii")


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line; returns the exit status."""
    parser = argparse.ArgumentParser(prog="mining", description=__doc__)
    parser.add_argument("model", help="path of a model, or the name of a shipped one")
    parser.add_argument(
        "folders", type=Path, nargs="+", metavar="FOLDER",
        help="labelled images in YOLO's layout, or a simulated flight",
    )  # fmt: skip
    parser.add_argument("-o", "--output", type=Path, required=True, help="new folder")
    parser.add_argument("--split", default="train")
    parser.add_argument("--side", type=int, default=Mining.side)
    parser.add_argument("--draws", type=int, default=Mining.draws)
    parser.add_argument("--easy", type=float, default=Mining.easy)
    parser.add_argument("--seed", type=int, default=Mining.seed)
    given = parser.parse_args(arguments)
    config = DetectorConfig(
        model=given.model, backend="onnxruntime", score_threshold=_LOOKED_AT, second_look="off"
    )
    mining = Mining(side=given.side, draws=given.draws, easy=given.easy, seed=given.seed)
    try:
        images = chain.from_iterable(
            read_bag(path) if is_bag(path) else read_labels(path, given.split)
            for path in given.folders
        )
        hard, easy = mine(load_detector(config), images, given.output, mining)
    except AerialGnssError as error:
        sys.stderr.write(f"mining: {error}\n")
        return 2
    sys.stdout.write(f"{hard} hard tiles and {easy} others in {given.output}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
