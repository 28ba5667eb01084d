# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A sheet of a detector's missed robots (top) and false boxes (bottom), evenly sampled.

python -m aerial_gnss_ros.training.failures MODEL FOLDER -o FAILURES.jpg
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import AerialGnssError, OutputError
from aerial_gnss_ros.detection.base import Detector, Image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.training.compare import labelled as open_images
from aerial_gnss_ros.training.labelled import LabelledImage
from aerial_gnss_ros.training.score import match

CELL = 160
"""px, of a picture on the sheet."""
_LEAST_VIEW = 48.0  # px of the image in a cell: small things are enlarged to this and no further
_GREEN, _RED, _WHITE = (0, 255, 0), (0, 0, 255), (255, 255, 255)


@dataclass(frozen=True)
class Failure:
    """One box on the sheet.

    Attributes:
        words: written into the corner.
        cell: (CELL, CELL, 3) the image round it, the box drawn.
    """

    words: str
    cell: Image


def failures(
    detector: Detector, images: Iterable[LabelledImage]
) -> tuple[list[Failure], list[Failure]]:
    """Return robots missed and false boxes, in the order of the images."""
    missed, false = [], []
    for labelled in images:
        image, truth = labelled.read(), labelled.truth
        found = detector.detect(image)
        matched = match(found, truth)
        missed += [
            Failure("missed", _cell(image, truth.corners[j], _GREEN))
            for j in np.flatnonzero(truth.counted & (matched.box < 0))
        ]
        false += [
            Failure(f"false {found.scores[i]:.2f}", _cell(image, found.xyxy[i], _RED))
            for i in np.flatnonzero(matched.robot == -1)
        ]
    return missed, false


def _cell(image: Image, corners: NDArray[np.float64], colour: tuple[int, int, int]) -> Image:
    middle = (corners[:2] + corners[2:]) / 2
    view = max(_LEAST_VIEW, 1.8 * float((corners[2:] - corners[:2]).max()))
    scale = CELL / view
    shift = (CELL - 1) / 2 - scale * middle
    matrix = np.array([[scale, 0.0, shift[0]], [0.0, scale, shift[1]]])
    cell = cv2.warpAffine(
        image, matrix, (CELL, CELL), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    low, high = (np.round(scale * edge + shift).astype(int).tolist() for edge in
                 (corners[:2], corners[2:]))  # fmt: skip
    return np.asarray(cv2.rectangle(cell, low, high, colour, 1), dtype=np.uint8)


def sheet(rows: list[list[Failure]], columns: int) -> Image:
    """Return one image: each row evenly sampled from its list, up to `columns`."""
    lines = []
    for row in rows:
        picked = sorted({int(i) for i in np.linspace(0, len(row) - 1, columns)}) if row else []
        cells = [_worded(row[i]) for i in picked]
        cells += [np.zeros((CELL, CELL, 3), np.uint8)] * (columns - len(cells))
        lines.append(np.hstack(cells))
    return np.vstack(lines)


def _worded(failure: Failure) -> Image:
    cell = failure.cell.copy()
    cv2.putText(cell, failure.words, (3, 13), cv2.FONT_HERSHEY_SIMPLEX, 0.42, _WHITE, 1)
    return cell


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line; returns the exit status."""
    default = DetectorConfig()
    parser = argparse.ArgumentParser(prog="failures", description=__doc__)
    parser.add_argument("model", help="path of a model, or the name of a shipped one")
    parser.add_argument("folder", type=Path, help="labelled images, or a simulated bag")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the picture to write")
    parser.add_argument("--split", default="test")
    parser.add_argument("--columns", type=int, default=10)
    parser.add_argument("--score-threshold", type=float, default=default.score_threshold)
    given = parser.parse_args(arguments)
    config = DetectorConfig(
        model=given.model, backend="onnxruntime", score_threshold=given.score_threshold
    )
    try:
        detector = load_detector(config)
        missed, false = failures(detector, open_images(given.folder, given.split))
        picture = sheet([missed, false], given.columns)
        if not cv2.imwrite(str(given.output), picture):
            raise OutputError(f"{given.output} cannot be written.")
    except AerialGnssError as error:
        sys.stderr.write(f"failures: {error}\n")
        return 2
    sys.stdout.write(f"{len(missed)} missed, {len(false)} false boxes; {given.output}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
