# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the second look costs: docs/results/detection.md.

    python benchmarks/second_look.py

Processor time of one thread for an image with a number of doubtful boxes, cutting out included,
medians taken in turns: all refused at the first look, and all looked at in every way; and the
memory that it holds more, with ONNX Runtime itself (anonymous, after a trim).
"""

from __future__ import annotations

import time
from dataclasses import replace

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from compiled_sizes import held_mb
from tables import columns, show

COUNTS, LONG_PX = (1, 4, 16, 32), (20.0, 60.0, 200.0)


def main() -> None:
    """Measure, and print two tables."""
    from aerial_gnss_ros.detection.config import DetectorConfig
    from aerial_gnss_ros.detection.select import second_look

    before = held_mb()
    look = second_look(DetectorConfig(threads=1))
    if look is None:
        raise SystemExit("the shipped model has no second look beside it.")
    rng = np.random.default_rng(1)
    image = rng.integers(0, 256, (720, 1280, 3), dtype=np.uint8)
    spent: dict[tuple[float, int, float], list[float]] = {}
    kinds = {"refused": 1.0, "in all ways": 0.0}
    for _ in range(30):
        for again_from in kinds.values():
            look.terms = replace(look.terms, again_from=again_from)
            for count in COUNTS:
                for long in LONG_PX:
                    middles = rng.uniform(100, 600, (count, 2))
                    xywh = np.hstack([middles, np.full((count, 2), long) * [1.0, 0.6]])
                    began = time.thread_time()
                    look.scores(image, xywh, np.full(count, 0.5))
                    key = again_from, count, long
                    spent.setdefault(key, []).append(time.thread_time() - began)
    rows = [
        [
            f"{count} boxes, {kind}",
            *(f"{1e3 * np.median(spent[again_from, count, long]):.2f}" for long in LONG_PX),
        ]
        for kind, again_from in kinds.items()
        for count in COUNTS
    ]
    show(columns(["ms", *(f"{long:g} px long" for long in LONG_PX)], rows), None)
    show(columns(["", "MB"], [["memory", f"{held_mb() - before:.0f}"]]), None)


if __name__ == "__main__":
    main()
