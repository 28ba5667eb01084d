# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labels of images by file name, from a table or YOLO's text files, and comparison with boxes.

A table has a row for each object: `file_name`, its class (`class` or `class_id`), left and top edge
(`x_px`, `y_px`; the first pixel reaches from 0 to 1), width and height (`width_px`, `height_px`; in
tables that state the image's own size under these names, `width_box_px`, `height_box_px`). A row
without a class states that the image has no objects.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.adapters.table_files import table_rows
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.detection.yolo import iou
from aerial_gnss_ros.text.sentences import cut, shown
from aerial_gnss_ros.training.label_lines import parse
from aerial_gnss_ros.training.labelled import Truth
from aerial_gnss_ros.training.score import MATCH_IOU, Score

NOTHING = "nothing"
OFF = "a robot, but off"
_MIDDLE = 0.5  # from edges counted from 0 to the middle of the first pixel
_ON_IOU = 0.1
_POSITION = ("x_px", "y_px")
_SIZES = (("width_box_px", "height_box_px"), ("width_px", "height_px"))


@dataclass(frozen=True)
class Labels:
    """Objects in one image.

    Attributes:
        classes: (n,) names.
        corners: (n, 4) left, top, right, bottom, px; the middle of the first pixel is (0, 0).
    """

    classes: tuple[str, ...]
    corners: NDArray[np.float64]

    def truth(self, class_names: Sequence[str]) -> Truth:
        """Return those of the classes that a detector knows."""
        known = [i for i, name in enumerate(self.classes) if name in class_names]
        corners = self.corners[known]
        return Truth(
            corners,
            np.ones(len(known), dtype=np.bool_),
            (corners[:, 2:] - corners[:, :2]).max(axis=1, initial=0.0),
            np.full(len(known), np.nan),
            np.array([class_names.index(self.classes[i]) for i in known], dtype=np.int64),
        )


class PictureLabels:
    """Labels of many images.

    Args:
        path: a table, or a folder with a text file for each picture as YOLO has them.
        class_names: of the detector; the text files have indices into them.

    Raises:
        InputError: neither, or damaged.
    """

    def __init__(self, path: Path, class_names: Sequence[str]) -> None:
        self._path = path
        self._folder = path if path.is_dir() else None
        self._names = tuple(class_names)
        self._rows = {} if path.is_dir() else _table(path)
        self._by_name: dict[str, list[str]] = {}
        for name in self._rows:
            self._by_name.setdefault(Path(name).name, []).append(name)
        self._used: dict[str, Path] = {}  # the first picture of each
        if path.is_dir() and not any(path.glob("*.txt")):
            raise InputError(
                f"{path} holds no label files (*.txt); give the folder of YOLO's text files, or a "
                "table."
            )

    def of(self, name: str, size: tuple[int, int]) -> Labels | None:
        """Return the labels of an image; None if it has none.

        Args:
            name: of its file; the folder counts only where several have a file of this name.
            size: width and height, px.

        Raises:
            InputError: the same labels were those of an image in another folder.
        """
        own = Path(name)
        if self._folder is None:
            named = [name] if name in self._rows else self._by_name.get(own.name, [])
            if len(named) != 1 or not self._free(named[0], own):
                return None
            return _labels(self._rows[named[0]])
        file = self._folder / f"{own.stem}.txt"
        if not file.is_file() or not self._free(file.name, own):
            return None
        return _labels(_yolo(file, self._names, size))

    def _free(self, label: str, picture: Path) -> bool:
        """Return whether labels are not those of an image in another folder, which has their name.

        Raises:
            InputError: they were taken for that image by its name without the folder.
        """
        before = self._used.setdefault(label, picture)
        if before.parent != picture.parent and str(before) != label:
            raise InputError(
                f"{self._path}: {label} would be the labels of {before} and of {picture}; score "
                "the folders separately, or give labels with the folders' names."
            )
        return before.parent == picture.parent


Row = tuple[str, float, float, float, float]


def _labels(rows: Sequence[Row]) -> Labels:
    boxes = np.array([row[1:] for row in rows], dtype=np.float64).reshape(-1, 4)
    low = boxes[:, :2] - _MIDDLE
    return Labels(tuple(row[0] for row in rows), np.hstack([low, low + boxes[:, 2:]]))


def _table(path: Path) -> dict[str, list[Row]]:
    rows: dict[str, list[Row]] = {}
    for line, row in table_rows(path, ("file_name", *_POSITION), "a table of labels"):
        of_picture = rows.setdefault(row["file_name"], [])
        kind = row.get("class", row.get("class_id", ""))
        if not kind:
            continue
        sizes = next((both for both in _SIZES if both[0] in row and both[1] in row), None)
        if sizes is None:
            raise InputError(f"{path} lacks the columns width_px, height_px; it has no boxes.")
        texts = [row[column] for column in (*_POSITION, *sizes)]
        try:
            left, top, width, height = map(float, texts)
        except ValueError as error:
            raise InputError(
                f"{path}, line {line}: {shown(texts)} must be left, top, width and height in px."
            ) from error
        if not (np.isfinite([left, top, width, height]).all() and min(width, height) >= 0.0):
            raise InputError(f"{path}, line {line}: {shown(texts)} is not a box.")
        of_picture.append((kind, left, top, width, height))
    if not rows:
        raise InputError(f"{path} has no rows; there is nothing to compare with.")
    return rows


def _yolo(file: Path, names: Sequence[str], size: tuple[int, int]) -> list[Row]:
    rows: list[Row] = []
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{file} cannot be read ({cut(str(error))}).") from error
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            class_id, u, v, width, height = parse(line, len(names))
        except InputError as error:
            raise InputError(f"{file}, line {number}: {error}.") from error
        wide, high = width * size[0], height * size[1]
        left, top = u * size[0] - wide / 2, v * size[1] - high / 2
        rows.append((names[class_id], left, top, wide, high))
    return rows


@dataclass
class Comparison:
    """Comparison of boxes with labels, image by image.

    Attributes:
        least_iou: of a box that matches a label.
        any_class: whether labels of all classes count as robots.
        score: robots found and missed, false boxes.
        labelled: number of images with labels.
        others: labels of classes that the detector does not know, by class.
        false_on: false boxes by the class under them, `OFF` (on a robot that counts, with too
            little overlap) or `NOTHING`.
        right_scores: scores of the boxes on robots.
        false_scores: scores of the false ones.
    """

    least_iou: float = MATCH_IOU
    any_class: bool = False
    score: Score = field(default_factory=Score)
    labelled: int = 0
    others: Counter[str] = field(default_factory=Counter)
    false_on: Counter[str] = field(default_factory=Counter)
    right_scores: list[float] = field(default_factory=list)
    false_scores: list[float] = field(default_factory=list)

    def add(self, found: Detections, labels: Labels) -> None:
        """Count one image."""
        self.labelled += 1
        if self.any_class:
            found = replace(found, class_ids=np.zeros_like(found.class_ids))
            labels = Labels(found.class_names[:1] * len(labels.classes), labels.corners)
        matched = self.score.add(found, labels.truth(found.class_names), self.least_iou)
        strange = [i for i, name in enumerate(labels.classes) if name not in found.class_names]
        self.others.update(labels.classes[i] for i in strange)
        corners = labels.corners[strange]
        false = np.flatnonzero(matched.robot == -1)
        self.right_scores += found.scores[matched.robot >= 0].tolist()
        self.false_scores += found.scores[false].tolist()
        overlap = iou(found.xyxy[false], corners)
        counted = np.delete(labels.corners, strange, axis=0)
        near = iou(found.xyxy[false], counted).max(axis=1, initial=0.0)
        for row, box, share in zip(overlap, false, near, strict=True):
            middle = found.xywh[box, :2]
            inside = ((middle >= corners[:, :2]) & (middle <= corners[:, 2:])).all(axis=1)
            fit = np.where(inside, row + 1.0, row)
            best = int(fit.argmax()) if fit.size else -1
            on = best >= 0 and fit[best] >= _ON_IOU
            kind = labels.classes[strange[best]] if on else OFF if share >= _ON_IOU else NOTHING
            self.false_on[kind] += 1
