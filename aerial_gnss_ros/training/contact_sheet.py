# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A contact sheet of labelled images with their boxes, for visual inspection."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.training.label_lines import parse

SHEET = "contact_sheet.png"

ROWS, COLUMNS = 6, 6
SIDE = 320
"""px, of each picture on the sheet."""
_COLOURS = ((0, 255, 255), (255, 0, 255), (0, 255, 0), (255, 160, 0), (0, 128, 255), (255, 255, 0))


def write_contact_sheet(folder: Path, split: str, stems: Sequence[str], file: Path) -> None:
    """Write a sheet with a row of variants for each of a few images, spread over all.

    Args:
        folder: a data set that `augment` writes.
        split: which of its sets.
        stems: names that the names of variants begin with.
        file: the PNG to write.
    """
    variants = {stem: _variants(folder, split, stem) for stem in sorted(stems)}
    shown = [stem for stem, images in variants.items() if images]
    labelled = [stem for stem in shown if any(_boxes(image) for image in variants[stem])]
    pool = labelled or shown
    spread = np.linspace(0, len(pool) - 1, ROWS) if pool else np.zeros(0)
    picked = [pool[i] for i in sorted({int(i) for i in spread})]
    rows = []
    columns = min(COLUMNS, max((len(variants[stem]) for stem in pool), default=1))
    for stem in picked:
        cells = [_cell(image) for image in variants[stem][:columns]]
        cells += [np.zeros((SIDE, SIDE, 3), np.uint8)] * (columns - len(cells))
        rows.append(np.hstack(cells))
    sheet = np.vstack(rows) if rows else np.zeros((SIDE, SIDE, 3), np.uint8)
    _, encoded = cv2.imencode(".png", sheet)
    file.write_bytes(encoded.tobytes())


def _variants(folder: Path, split: str, stem: str) -> list[Path]:
    found = [
        folder / "images" / split / f"{stem}_{number:02d}.jpg" for number in range(2 * COLUMNS)
    ]
    return [path for path in found if path.is_file()]


def _boxes(image: Path) -> list[tuple[int, float, float, float, float]]:
    labels = image.parent.parent.parent / "labels" / image.parent.name / f"{image.stem}.txt"
    # They were checked when written, so any number of classes is accepted.
    return [parse(line, 2**31) for line in labels.read_text(encoding="ascii").splitlines()]


def _cell(path: Path) -> NDArray[np.uint8]:
    """Return the image, fitted into the middle of a square, its boxes drawn."""
    image = read_image(path)
    height, width = image.shape[:2]
    scale = SIDE / max(height, width)
    small_size = max(1, round(width * scale)), max(1, round(height * scale))
    small = cv2.resize(image, small_size, interpolation=cv2.INTER_AREA)
    for number, x, y, w, h in _boxes(path):
        low = round((x - w / 2) * small_size[0]), round((y - h / 2) * small_size[1])
        high = round((x + w / 2) * small_size[0]), round((y + h / 2) * small_size[1])
        cv2.rectangle(small, low, high, _COLOURS[number % len(_COLOURS)], 1)
    cell = np.zeros((SIDE, SIDE, 3), np.uint8)
    top, left = (SIDE - small_size[1]) // 2, (SIDE - small_size[0]) // 2
    cell[top : top + small_size[1], left : left + small_size[0]] = small
    return cell
