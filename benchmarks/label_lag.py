# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether a video's labels lag behind what they label.

python benchmarks/label_lag.py IMAGES labels.csv --kind swimmer

Each label is compared with the outline of what stands out from the water nearest to it in the same
image, found in that image alone: it cannot lag. Where the labels are s images late, they are off by
s times the object's motion an image, whatever the direction: s is the least-squares slope, its
error from leaving out one image after the other (jackknife). `still` are the labels whose object
moves less than 3 px an image, `fast` those of more than 40.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.bags.pictures import IMAGE_ENDINGS
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.detection.second_look_terms import Terms
from aerial_gnss_ros.detection.taught import Proposer
from aerial_gnss_ros.teaching.tracks import overlap
from aerial_gnss_ros.training.picture_labels import PictureLabels

Array = NDArray[np.float64]
NEAR_PX, ALIKE_PX, STILL_PX, FAST_PX = 60.0, 25.0, 3.0, 40.0


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("images", type=Path)
    parser.add_argument("labels", type=Path)
    parser.add_argument("--kind", required=True)
    args = parser.parse_args()
    files = sorted(f for f in args.images.iterdir() if f.suffix.lower() in IMAGE_ENDINGS)
    table = PictureLabels(args.labels, ())
    labels = [_boxes(table, file.name, args.kind) for file in files]
    proposer = Proposer(Terms(from_score=0.3, most=64))
    number, off, moved, pairs = [], [], [], []
    for i in range(1, len(files) - 1):
        seen = proposer.detect(read_image(files[i])).xywh
        for box in labels[i]:
            back, on = _shift(labels[i], labels[i - 1]), _shift(labels[i], labels[i + 1])
            before = _nearest(labels[i - 1], box + back, ALIKE_PX)
            after = _nearest(labels[i + 1], box + on, ALIKE_PX)
            found = _nearest(seen, box, NEAR_PX)
            if before is None or after is None or found is None:
                continue
            number.append(i)
            off.append(found[:2] - box[:2])
            moved.append((after[:2] - before[:2]) / 2.0)
            pairs.append((box, found))
    of, offset, motion = np.array(number), np.array(off), np.array(moved)
    late = _slope(offset, motion)
    every = [_slope(offset[of != one], motion[of != one]) for one in np.unique(of)]
    n = len(every)
    error = np.sqrt((n - 1) / n * np.square(np.array(every) - np.mean(every)).sum())
    speed = np.linalg.norm(motion, axis=1)
    rest = offset - late * motion
    long_px = np.median([box[2:].max() for box, _ in pairs])
    print(f"{len(of)} labels in {n} images, {long_px:.0f} px long (median)")
    print(f"labels are late by {late:.2f} +- {error:.2f} images")
    fast = speed >= FAST_PX
    for name, chosen in (("still", speed < STILL_PX), ("moving", (speed >= STILL_PX) & ~fast),
                         ("fast", fast)):  # fmt: skip
        if not chosen.any():
            continue
        apart = np.linalg.norm(offset[chosen], axis=1)
        left = np.linalg.norm(rest[chosen], axis=1)
        print(f"{name}: {chosen.sum()} labels, off by {np.median(apart):.1f} px (median; 90 %: "
              f"{np.percentile(apart, 90):.1f}), without the lag {np.median(left):.1f} "
              f"({np.percentile(left, 90):.1f})")  # fmt: skip
    for name, fits in (
        ("the outline", [overlap(box, found) for box, found in pairs]),
        (
            "with the label's size",
            [overlap(box, np.array([*found[:2], *box[2:]])) for box, found in pairs],
        ),
        (
            "with the label's middle",
            [overlap(box, np.array([*box[:2], *found[2:]])) for box, found in pairs],
        ),
    ):
        print(f"{name}: IoU 0.5 and more in {np.mean(np.array(fits) >= 0.5):.3f} of them")
    ratio = np.array([found[2:].prod() / box[2:].prod() for box, found in pairs])
    print(f"outline's area relative to the label's: {np.percentile(ratio, [5, 50, 95]).round(2)}")


def _boxes(table: PictureLabels, name: str, kind: str) -> Array:
    own = table.of(name, (0, 0))
    if own is None:
        return np.zeros((0, 4))
    corners = own.corners[[one == kind for one in own.classes]]
    return np.hstack([(corners[:, :2] + corners[:, 2:]) / 2.0, corners[:, 2:] - corners[:, :2]])


def _nearest(boxes: Array, box: Array, near_px: float) -> Array | None:
    """Return the box (4,) whose middle is the nearest; None: all are far."""
    apart = np.linalg.norm(boxes[:, :2] - box[:2], axis=1)
    return boxes[apart.argmin()] if apart.min(initial=np.inf) < near_px else None


def _shift(boxes: Array, others: Array) -> Array:
    """Return the shift (4,) that moves most boxes onto others: the camera's motion, px."""
    ways = (others[None, :, :2] - boxes[:, None, :2]).reshape(-1, 2)
    fits = np.linalg.norm(ways[:, None] - ways[None], axis=2) < ALIKE_PX
    best = ways[fits.sum(axis=1).argmax()] if len(ways) else np.zeros(2)
    return np.array([*best, 0.0, 0.0])


def _slope(offset: Array, motion: Array) -> float:
    return float((offset * motion).sum() / np.square(motion).sum())


if __name__ == "__main__":
    main()
