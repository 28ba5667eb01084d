# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images for calibrating an 8-bit export: they show the value ranges of a network's layers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.detection.onnx_model import InputSize, tensor
from aerial_gnss_ros.training.contact_sheet import SHEET
from aerial_gnss_ros.training.labelled import ENDINGS

USUAL_COUNT = 64
"""More images change the ranges little and take longer."""


def choose_images(folder: Path, count: int = USUAL_COUNT) -> list[Path]:
    """Return at most `count` images below a folder, evenly sampled in path order.

    Raises:
        InputError: no such folder, or no image in it.
    """
    if not folder.is_dir():
        raise InputError(
            f"the folder of calibration images {folder} does not exist; give one with images as "
            "the camera takes them."
        )
    paths = sorted(
        path
        for path in folder.rglob("*")
        if path.suffix.lower() in ENDINGS and path.name != SHEET  # no camera takes that
    )
    if not paths:
        raise InputError(
            f"{folder} has no calibration images ({', '.join(ENDINGS)}); give a folder with images "
            "as the camera takes them."
        )
    places = np.linspace(0, len(paths) - 1, min(count, len(paths)))
    return [paths[round(float(place))] for place in places]


class CalibrationImages:
    """Gives images to ONNX Runtime's calibration one by one, as the network would be given them.

    Args:
        paths: of the images.
        name: of the network's input.
        size: of the network's input.
        longest: longest side where the size is free, px.
        report: called with the number of images given so far.
    """

    def __init__(
        self,
        paths: Sequence[Path],
        name: str,
        size: InputSize,
        longest: int,
        report: Callable[[int], None] = lambda _: None,
    ) -> None:
        self._paths = list(paths)
        self._name, self._size, self._longest = name, size, longest
        self._report = report
        self._given = 0

    def get_next(self) -> dict[str, NDArray[Any]] | None:
        """Return the next image under the name of the input, None after the last.

        Raises:
            InputError: a damaged image.
        """
        self._report(self._given)
        if self._given == len(self._paths):
            return None
        image = read_image(self._paths[self._given])
        self._given += 1
        fitted = self._size.letterbox(image, self._longest).apply(image)
        return {self._name: tensor(fitted, np.float32)}
