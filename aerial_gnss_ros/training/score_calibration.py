# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Turns a small detector's scores into frequencies: of boxes with score 0.3, 3 in 10 are robots.

python -m aerial_gnss_ros.training.score_calibration MODEL.onnx FOLDER ... -o CALIBRATED.onnx

The loss of its training weighs robots and water unequally, so that the detector is hardly sure of
anything. Its log odds are scaled and shifted to the likeliest ones on held-out images (Platt,
Probabilistic Outputs for Support Vector Machines, 1999), which changes no order of boxes.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.bags.partial import partial, refuse_existing
from aerial_gnss_ros.core.values.errors import AerialGnssError, InputError, ModelError
from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.second_look_terms import log_odds
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.resources import install_hint
from aerial_gnss_ros.training.compare import images_of
from aerial_gnss_ros.training.labelled import LabelledImage
from aerial_gnss_ros.training.score import match

LEAST_SCORE = 0.02
"""Boxes with smaller scores tell nothing about larger ones."""
_STEPS = 50


@dataclass(frozen=True)
class Calibration:
    """Log odds become `scale` times themselves plus `shift`."""

    scale: float = 1.0
    shift: float = 0.0


def calibration(odds: NDArray[np.float64], right: NDArray[np.bool_]) -> Calibration:
    """Return the likeliest calibration of boxes, by Newton's method.

    Args:
        odds: (n,) log odds of the detector.
        right: (n,) whether each box is a robot.

    Raises:
        InputError: too few boxes, all right or all wrong.
    """
    known = np.stack([odds, np.ones(len(odds))], axis=1)
    # Platt's targets: as if one more box of each kind had been seen.
    robots, others = int(right.sum()), int((~right).sum())
    if min(robots, others) < 2:
        raise InputError(
            f"of {len(odds)} boxes {robots} are right; give images on which some are right and "
            "some are wrong."
        )
    wanted = np.where(right, (robots + 1.0) / (robots + 2.0), 1.0 / (others + 2.0))
    found = np.array([1.0, 0.0])
    for _ in range(_STEPS):
        chance = 1.0 / (1.0 + np.exp(-known @ found))
        slope = known.T @ (wanted - chance)
        bend = (known * (chance * (1.0 - chance))[:, None]).T @ known + 1e-9 * np.eye(2)
        found = found + np.linalg.solve(bend, slope)
    return Calibration(float(found[0]), float(found[1]))


def boxes_of(
    detector: Detector, images: Iterable[LabelledImage]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return log odds (n,) of a detector's boxes, and whether each is a robot.

    Boxes on robots that do not count are left out.
    """
    odds, right = [np.zeros(0)], [np.zeros(0, dtype=np.bool_)]
    for image in images:
        found = detector.detect(image.read())
        robot = match(found, image.truth).robot
        odds.append(log_odds(found.scores[robot != -2]))
        right.append(robot[robot != -2] >= 0)
    return np.concatenate(odds), np.concatenate(right)


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line; returns the exit status."""
    parser = argparse.ArgumentParser(prog="score_calibration", description=__doc__.splitlines()[0])
    parser.add_argument("model", type=Path, help="a small detector, .onnx")
    parser.add_argument("folders", type=Path, nargs="+", help="labelled images or flights")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the .onnx file to write")
    given = parser.parse_args(arguments)
    try:
        _calibrate(given)
    except AerialGnssError as error:
        sys.stderr.write(f"score_calibration: {error}\n")
        return 2
    return 0


def _calibrate(given: argparse.Namespace) -> None:
    try:
        from aerial_gnss_ros.training import small_network
    except ImportError as error:
        raise ModelError(
            f"calibrating a detector needs {error.name}; install it with "
            f"{install_hint('ultralytics')}."
        ) from error
    refuse_existing(given.output)
    names = small_network.names_of(given.model)
    network = small_network.read(given.model, len(names))
    with partial(given.output) as file:
        small_network.write(network, names, file)
        detector = load_detector(
            DetectorConfig(
                model=str(file), backend="onnxruntime", score_threshold=LEAST_SCORE,
                second_look="off",
            )
        )  # fmt: skip
        found = calibration(*boxes_of(detector, images_of(given.folders)))
        small_network.write(network, names, file, found.scale, found.shift)
    sys.stdout.write(f"log odds times {found.scale:.2f}, plus {found.shift:.2f}; {given.output}\n")


if __name__ == "__main__":
    sys.exit(main())
