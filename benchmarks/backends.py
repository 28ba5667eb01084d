# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Processor time of a model's files on each back end, as ratios, with their scores beside.

    aerial-gnss export aqua_yolo11n.onnx -o int8.onnx --precision int8 --calibration IMAGES
    python benchmarks/backends.py aqua_yolo11n.onnx int8.onnx --score FRAMES

Time is what one thread of the processor worked, median, all taken in turns: other programs disturb
it little, and ratios less. Two threads take somewhat more than half of it.
"""

from __future__ import annotations

import argparse
import importlib.util
import sys
import time
from pathlib import Path

import numpy as np

from aerial_gnss_ros.core.values.errors import AerialGnssError
from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.training.compare import compare, for_scoring, labelled, table


def detectors(models: list[str]) -> list[Detector]:
    """Return each model on ONNX Runtime, and on OpenVINO in each precision."""
    ways = [("onnxruntime", "f32")]
    if importlib.util.find_spec("openvino"):
        ways = [("openvino", "f32"), ("openvino", "auto"), *ways]
    return [
        load_detector(
            for_scoring(
                DetectorConfig(model=model, backend=backend, precision=precision, threads=1)
            )
        )
        for model in models
        for backend, precision in ways
    ]


def times(found: list[Detector], rounds: int) -> list[float]:
    """Return for each detector the median processor time of an image, ms."""
    image = np.random.default_rng(0).integers(0, 255, (720, 1280, 3), dtype=np.uint8)
    spent: list[list[float]] = [[] for _ in found]
    for _ in range(rounds + 1):
        for detector, mine in zip(found, spent, strict=True):
            started = time.process_time()
            detector.detect(image)
            mine.append((time.process_time() - started) * 1e3)
    return [float(np.median(mine[1:])) for mine in spent]


def main() -> int:
    """Run from the command line; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("models", nargs="+", help="paths, or names of shipped ones")
    parser.add_argument("--rounds", type=int, default=9, help="images each (default 9)")
    parser.add_argument("--score", type=Path, help="labelled images or a simulated bag")
    parser.add_argument("--split", default="test")
    given = parser.parse_args()
    try:
        found = detectors(given.models)
        taken = times(found, given.rounds)
        print("| model | ms of one thread | ratio |\n|---|---|---|")
        for detector, milliseconds in zip(found, taken, strict=True):
            print(f"| {detector.name} | {milliseconds:.1f} | {milliseconds / taken[0]:.2f} |")
        if given.score is not None:
            print("\n" + table(compare(found, labelled(given.score, given.split))), end="")
    except AerialGnssError as error:
        print(f"backends: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
