# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How well boxes traced through the waves agree with masks that Cycles renders of the same robots.

python benchmarks/blender_labels.py --count 20        # needs the extra [blender]
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from aerial_gnss_ros.simulation.blender import studio
from aerial_gnss_ros.simulation.blender.masks import box_of, coverage
from aerial_gnss_ros.simulation.blender.ranges import RANGES
from aerial_gnss_ros.simulation.blender.shot import random_shot
from aerial_gnss_ros.simulation.blender.tracing import Tracer, box


def main() -> None:
    """Print the differences of the boxes' four edges."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20, help="robots")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    off, deep, missing = [], [], 0
    with tempfile.TemporaryDirectory() as folder:
        for i in range(given.count):
            rng = np.random.default_rng([given.seed, i])
            shot = random_shot(rng, RANGES[("train", "unseen")[i % 2]], (240, 180), 1.0)
            built = studio.build(replace(shot, robots=shot.robots[:1], props=()), 32, seed=i)
            outline = Tracer(built).outline("aqua_01")
            traced = box(outline, shot.view.window) if outline is not None else None
            rendered = box_of(coverage(built, "aqua_01", Path(folder)), shot.view.window)
            if traced is None or rendered is None:
                missing += (traced is None) != (rendered is None)
                continue
            off.append(np.abs(np.subtract(traced, rendered)))
            deep.append(shot.robots[0].depth)
            print(
                f"{i}: depth {deep[-1]:+.2f} m, edges off by {np.round(off[-1], 2)} px", flush=True
            )
    edges = np.array(off)
    print(
        f"{len(edges)} robots, {missing} found by only one of both; edges off by median "
        f"{np.median(edges):.2f}, p95 {np.percentile(edges, 95):.2f}, most {edges.max():.2f} px"
    )


if __name__ == "__main__":
    main()
