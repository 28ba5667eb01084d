# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lines of a label file in YOLO's layout: `class x y width height`, relative to the image."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.sentences import counted

OVERHANG = 1e-3
"""Greatest overhang of an edge beyond the image, relative to its size: label tools round."""


def parse(line: str, classes: int) -> tuple[int, float, float, float, float]:
    """Return class, centre x, y, width and height, the latter relative to the image.

    Args:
        line: of a label file.
        classes: how many there are.

    Raises:
        InputError: with the error, to be prefixed with the file's name.
    """
    words = line.split()
    if len(words) != 5:
        raise InputError(
            f"has {counted(len(words), 'value')}, but a box is `class x y width "
            "height` (outlines and turned boxes are not read)"
        )
    try:
        number, *place = [float(word) for word in words]
    except ValueError as error:
        raise InputError(f"{line.strip()!r} is not five numbers") from error
    if not all(map(math.isfinite, (number, *place))):
        raise InputError(f"{line.strip()!r} is not five numbers")
    if number != int(number) or not 0 <= number < classes:
        meant = "0" if classes == 1 else f"0 to {classes - 1}"
        raise InputError(f"class {words[0]} is not in data.yaml, which has {meant}")
    x, y, width, height = place
    if not (0.0 <= x <= 1.0 and 0.0 <= y <= 1.0):
        raise InputError(f"the centre ({x:g}, {y:g}) is outside 0 to 1: it may be in pixels")
    if not (0.0 < width <= 1.0 + 2 * OVERHANG and 0.0 < height <= 1.0 + 2 * OVERHANG):
        raise InputError(f"the size {width:g} x {height:g} is not above 0 and at most 1")
    edges = (x - width / 2, y - height / 2, x + width / 2, y + height / 2)
    if min(edges) < -OVERHANG or max(edges) > 1.0 + OVERHANG:
        raise InputError(f"the box reaches beyond the image, from {min(edges):g} to {max(edges):g}")
    return int(number), x, y, width, height


def as_text(
    classes: Iterable[int], boxes: Sequence[NDArray[np.float64]], width: int, height: int
) -> str:
    """Return label lines of boxes in px (centre, size; the first pixel spans 0 to 1)."""
    lines = []
    for number, (x, y, w, h) in zip(classes, boxes, strict=True):
        place = (x / width, y / height, w / width, h / height)
        lines.append(f"{number} " + " ".join(f"{value:.6f}" for value in place) + "\n")
    return "".join(lines)
