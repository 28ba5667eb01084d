# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What following the robots (search.mode roi) finds and takes, beside looking at whole images.

    aerial-gnss simulate -o flight --flight transit --rate 30 --duration 8 --fixed-gimbal --speed 4
    python benchmarks/search_modes.py flight --markdown search_modes.md

Simulated flights with images and true boxes; every mode sees the same images in the same order
with the same network. Robots of at least 16 x 8 px count, found at IoU 0.5. Processor time is that
of one thread, so that other programs do not disturb it.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from tables import keep

from aerial_gnss_ros.core.values.errors import AerialGnssError
from aerial_gnss_ros.detection.config import detector_config
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.training.labelled_bag import read_bag
from aerial_gnss_ros.training.score import Score

HEAD = (
    "| flight | mode | robots in images | recall | false boxes | centre error, px (median) | "
    "processor time an image, ms (mean / p95) |"
)


def main() -> int:
    """Score and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("flights", type=Path, nargs="+")
    parser.add_argument("--modes", nargs="+", default=["full", "roi"])
    parser.add_argument("--scan-images", type=int, default=15)
    parser.add_argument("--backend", default="auto")
    parser.add_argument("--model", help="instead of the shipped one")
    parser.add_argument("--markdown", type=Path, help="write the table to this file")
    args = parser.parse_args()
    cv2.setNumThreads(1)
    lines = [HEAD, "|---" * 7 + "|"]
    try:
        for flight in args.flights:
            for mode in args.modes:
                lines.append(row(flight, mode, args))
                sys.stdout.write(lines[-1] + "\n")
                sys.stdout.flush()
    except AerialGnssError as error:
        sys.stderr.write(f"search_modes: {error}\n")
        return 2
    keep("\n".join(lines) + "\n", args.markdown)
    return 0


def row(flight: Path, mode: str, args: argparse.Namespace) -> str:
    """Return the table's line for one flight and mode."""
    values = {
        "backend": args.backend, "threads": 1, "search.mode": mode,
        "search.scan_images": args.scan_images,
    }  # fmt: skip
    detector = load_detector(
        detector_config(values | ({"model": args.model} if args.model else {}))
    )
    score, spent = Score(), list[float]()
    for labelled in read_bag(flight):
        image = labelled.read()
        started = time.process_time()
        found = detector.detect(image)
        spent.append(1e3 * (time.process_time() - started))
        score.add(found, labelled.truth)
    return cells(flight.name, mode, score, spent)


def cells(flight: str, mode: str, score: Score, spent: Sequence[float]) -> str:
    """Return one line of the table."""
    every = score.overall
    error = np.median(score.centre_error_px) if score.centre_error_px else float("nan")
    return (
        f"| {flight} | {mode} | {every.robots} | {every.recall:.4f} | {every.false} | "
        f"{error:.2f} | {np.mean(spent):.1f} / {np.percentile(spent, 95):.1f} |"
    )


if __name__ == "__main__":
    sys.exit(main())
