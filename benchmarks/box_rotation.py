# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How well a box is carried through a turn: corners against ellipse, on the simulated hexapod.

The hexapod's outline is seen from random directions, boxed, turned in the image, and boxed again;
that second box is the truth for what `aerial-gnss augment` makes of the first.

python benchmarks/box_rotation.py
"""

from __future__ import annotations

import argparse

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.hexapod import hexapod
from aerial_gnss_ros.training.carrying import carry, moved, rectangle

Array = NDArray[np.float64]
EVERYTHING = rectangle(1e6, 1e6) - 5e5


def outline(rng: np.random.Generator) -> Array:
    """Return the hexapod's points (n, 2) px, 100 px long, seen up to 70 deg off the vertical."""
    vertices = 100.0 / 0.65 * hexapod(rng.uniform(0.0, 2.0 * np.pi)).vertices
    tilt, yaw = np.radians(rng.uniform(0.0, 70.0)), rng.uniform(0.0, 2.0 * np.pi)
    east = np.cos(yaw) * vertices[:, 0] - np.sin(yaw) * vertices[:, 1]
    north = np.sin(yaw) * vertices[:, 0] + np.cos(yaw) * vertices[:, 1]
    down = -north * np.cos(tilt) - vertices[:, 2] * np.sin(tilt)
    return np.stack([east, down], axis=1)


def box(points: Array) -> Array:
    """Return the centre and size (4,) of the box round points (n, 2)."""
    low, high = points.min(axis=0), points.max(axis=0)
    return np.concatenate([(low + high) / 2, high - low])


def overlap(a: Array, b: Array) -> float:
    """Return the intersection over union of two boxes (4,)."""
    low = np.maximum(a[:2] - a[2:] / 2, b[:2] - b[2:] / 2)
    high = np.minimum(a[:2] + a[2:] / 2, b[:2] + b[2:] / 2)
    both = float(np.prod(np.maximum(high - low, 0.0)))
    return both / float(np.prod(a[2:]) + np.prod(b[2:]) - both)


def main() -> None:
    """Print a table for a user to read, and for docs/howto/training.md."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--views", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    views = [outline(rng) for _ in range(given.views)]
    print("| turn up to, deg | box of | IoU median | IoU 5th percentile | area | centre off, px |")
    print("|---|---|---|---|---|---|")
    for most in (5, 10, 15, 30, 45):
        results: dict[str, list[tuple[float, float, float]]] = {"corners": [], "ellipse": []}
        for points in views:
            turn = np.radians(rng.uniform(-most, most))
            matrix = np.eye(3)
            matrix[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
            before, truth = box(points), box(moved(points, matrix))
            corners = rectangle(*before[2:]) + before[:2] - before[2:] / 2
            carried = {
                "corners": box(moved(corners, matrix)),
                "ellipse": carry(before[None], matrix, EVERYTHING)[0],
            }
            for name, found in carried.items():
                area = float(np.prod(found[2:]) / np.prod(truth[2:]))
                off = float(np.hypot(*(found[:2] - truth[:2])))
                results[name].append((overlap(truth, found), area, off))
        for name, rows in results.items():
            iou, area, off = np.array(rows).T
            print(
                f"| {most} | {name} | {np.median(iou):.3f} | {np.percentile(iou, 5):.3f} "
                f"| {np.exp(np.log(area).mean()):.3f} | {np.median(off):.2f} |"
            )


if __name__ == "__main__":
    main()
