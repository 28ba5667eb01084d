# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads the output of a YOLO network: boxes, scores, and non-maximum suppression."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.text.sentences import counted

_CANDIDATES = 2000  # more boxes before suppression are noise, and suppression is quadratic
_END_TO_END_COLUMNS = 6


@dataclass(frozen=True)
class Head:
    """Output format of a network.

    Attributes:
        classes: number of classes.
        end_to_end: True for (1, n, 6) rows of left, top, right, bottom, score, class, already
            suppressed; False for (1, 4 + classes, n) columns of centre, size and class scores.
    """

    classes: int
    end_to_end: bool

    @classmethod
    def of(cls, shape: tuple[int, ...], classes: int | None, where: str) -> Head:
        """Return the head from the shape of an output.

        Args:
            shape: of the network's output for one image.
            classes: number of classes if the model says so, else None.
            where: the model, for the error.

        Raises:
            ModelError: not the output of a YOLO detection network.
        """
        if len(shape) == 3 and shape[0] == 1:
            if shape[2] == _END_TO_END_COLUMNS and (classes is None or shape[1] != 4 + classes):
                if classes is None:
                    raise ModelError(
                        f"{where} carries no class names and their number does not follow from "
                        f"its output {list(shape)}; give class_names."
                    )
                return cls(classes, end_to_end=True)
            if classes is None and 5 <= shape[1] < shape[2]:
                return cls(shape[1] - 4, end_to_end=False)
            if classes is not None and shape[1] == 4 + classes:
                return cls(classes, end_to_end=False)
        known = "" if classes is None else f" for {counted(classes, 'class')}"
        wanted = "4 + classes" if classes is None else str(4 + classes)
        raise ModelError(
            f"{where} gives {list(shape)}, but a YOLO detection model{known} gives "
            f"[1, {wanted}, boxes] or [1, boxes, 6]; export it with task detect."
        )

    def decode(
        self, output: NDArray[Any], score_threshold: float, iou_threshold: float, most: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
        """Return corners (n, 4) in network pixels, scores (n,) and classes (n,), best first."""
        if self.end_to_end:
            rows = output[0].astype(np.float64)
            rows = rows[rows[:, 4] >= score_threshold]
            rows = rows[np.argsort(-rows[:, 4], kind="stable")[:most]]
            return rows[:, :4], rows[:, 4], rows[:, 5].astype(np.int64)
        table = output[0]
        best = table[4:].max(axis=0)
        chosen = np.flatnonzero(best >= score_threshold)
        chosen = chosen[np.argsort(-best[chosen], kind="stable")[:_CANDIDATES]]
        scores = best[chosen].astype(np.float64)
        classes = table[4:, chosen].argmax(axis=0).astype(np.int64)
        boxes = table[:4, chosen].T.astype(np.float64)
        corners = np.hstack([boxes[:, :2] - boxes[:, 2:] / 2, boxes[:, :2] + boxes[:, 2:] / 2])
        kept = suppress(corners, classes, iou_threshold, most)
        return corners[kept], scores[kept], classes[kept]


def suppress(
    corners: NDArray[np.float64], classes: NDArray[np.int64], iou_threshold: float, most: int
) -> NDArray[np.int64]:
    """Return the indices that stay after non-maximum suppression within each class.

    Args:
        corners: (n, 4) left, top, right, bottom, best score first.
        classes: (n,); boxes of different classes do not suppress one another.
        iou_threshold: of two boxes that overlap more than this the earlier one stays.
        most: at most this many stay.
    """
    kept: list[int] = []
    left = np.arange(len(corners))
    while left.size and len(kept) < most:
        first, left = int(left[0]), left[1:]
        kept.append(first)
        overlap = iou(corners[first : first + 1], corners[left])[0]
        left = left[(overlap <= iou_threshold) | (classes[left] != classes[first])]
    return np.array(kept, dtype=np.int64)


def iou(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return intersection over union (n, m) of corners (n, 4) with corners (m, 4)."""
    low = np.maximum(a[:, None, :2], b[None, :, :2])
    high = np.minimum(a[:, None, 2:], b[None, :, 2:])
    shared = np.clip(high - low, 0.0, None).prod(axis=2)
    area_a = (a[:, 2:] - a[:, :2]).prod(axis=1)
    area_b = (b[:, 2:] - b[:, :2]).prod(axis=1)
    union = area_a[:, None] + area_b[None, :] - shared
    ratio: NDArray[np.float64] = shared / np.maximum(union, np.finfo(np.float64).tiny)
    return ratio
