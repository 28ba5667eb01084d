# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads labelled images in YOLO's layout, with the simulation's meta.csv if present."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.adapters.table_files import table_rows
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.text.sentences import cut

ENDINGS = (".jpg", ".jpeg", ".png")


@dataclass(frozen=True)
class Truth:
    """The robots in one image.

    Attributes:
        corners: (n, 4) left, top, right, bottom, px; the middle of the first pixel is (0, 0).
        counted: (n,) whether a detector is expected to detect it.
        long_px: (n,) long side of the robot (of its box without meta.csv).
        contrast: (n,) against the water, 0 to 1; NaN without meta.csv.
        class_ids: (n,) index of the class.
    """

    corners: NDArray[np.float64]
    counted: NDArray[np.bool_]
    long_px: NDArray[np.float64]
    contrast: NDArray[np.float64]
    class_ids: NDArray[np.int64]


@dataclass(frozen=True)
class LabelledImage:
    """An image and its robots.

    Attributes:
        name: file name, or topic and stamp.
        truth: the robots.
        read: returns (height, width, 3) blue, green, red; InputError if it is not an image.
    """

    name: str
    truth: Truth
    read: Callable[[], Image]


def read_labels(folder: Path, split: str) -> Iterator[LabelledImage]:
    """Yield the images of `folder`/images/`split` with their training boxes.

    Raises:
        InputError: no such images, or a label that cannot be read.
    """
    for path in _images(folder, split):
        labels = folder / "labels" / split / f"{path.stem}.txt"
        yield LabelledImage(path.name, _from_labels(labels, path), partial(read_image, path))


def _images(folder: Path, split: str) -> list[Path]:
    images = folder / "images" / split
    paths = [path for path in sorted(images.glob("*")) if path.suffix.lower() in ENDINGS]
    if not paths:
        every = sorted(p for p in images.parent.glob("*") if p.is_dir() and any(p.iterdir()))
        raise InputError(f"{images} has no images; {_advice([p.name for p in every])}.")
    return paths


def _advice(splits: list[str]) -> str:
    if splits:
        return f"choose another split (--split); there are {', '.join(splits)}"
    return "give a folder in YOLO's layout (images/SPLIT, labels/SPLIT)"


def read_folder(folder: Path, split: str) -> Iterator[LabelledImage]:
    """Yield the images of `folder`/images/`split` by name, each with its truth.

    Args:
        folder: with images/, labels/ and perhaps meta.csv, as `simulation.dataset` writes it.
        split: such as train, val or test.

    Raises:
        InputError: no such images, or a label that cannot be read.
    """
    meta = _read_meta(folder / "meta.csv", split)
    for path in _images(folder, split):
        if meta is None:
            labels = folder / "labels" / split / f"{path.stem}.txt"
            truth = _from_labels(labels, path)
        else:
            truth = _of_meta(folder / "meta.csv", meta.get(path.name, []))
        yield LabelledImage(path.name, truth, partial(read_image, path))


def _read_meta(path: Path, split: str) -> dict[str, list[dict[str, str]]] | None:
    """Return the rows of each image; None if the simulation recorded none for this split."""
    if not path.is_file():
        return None
    rows: dict[str, list[dict[str, str]]] = {}
    for _, row in table_rows(path, ("split", "image"), "the meta.csv of `simulate --dataset`"):
        if row["split"] == split:
            rows.setdefault(row["image"], []).append(row)
    return rows or None


def _of_meta(path: Path, rows: Sequence[Mapping[str, Any]]) -> Truth:
    try:
        return truth_of_rows(rows)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path} has an invalid row: {cut(str(error))}.") from error


def truth_of_rows(rows: Sequence[Mapping[str, Any]]) -> Truth:
    """Return the simulation's truth of the robots in one image, one row each.

    Args:
        rows: with the columns of meta.csv (`RobotLabel.figures`), as numbers or as text.

    Raises:
        KeyError, TypeError, ValueError: a column is missing or not a number.
    """

    def column(name: str) -> NDArray[np.float64]:
        return np.array([float(row[name]) for row in rows], dtype=np.float64)

    edges = [column(name) for name in ("left", "top", "right", "bottom")]
    return Truth(
        np.stack(edges, axis=1),
        column("scored") > 0,
        column("long_px"),
        column("contrast"),
        np.zeros(len(rows), dtype=np.int64),  # the simulation knows one class
    )


def _from_labels(labels: Path, image: Path) -> Truth:
    try:
        lines = labels.read_text(encoding="ascii").splitlines() if labels.is_file() else []
        table = np.array([[float(word) for word in line.split()] for line in lines if line.strip()])
        table = table.reshape(-1, 5)
    except (OSError, ValueError) as error:  # UnicodeDecodeError is one of them
        raise InputError(f"{labels} must have lines of `class x y width height`.") from error
    pixels = read_image(image)
    size = np.array([pixels.shape[1], pixels.shape[0]], dtype=np.float64)
    centre, extent = table[:, 1:3] * size - 0.5, table[:, 3:5] * size
    count = len(table)
    return Truth(
        np.hstack([centre - extent / 2, centre + extent / 2]),
        np.ones(count, dtype=np.bool_),
        extent.max(axis=1) if count else np.zeros(0),
        np.full(count, np.nan),
        table[:, 0].astype(np.int64),
    )
