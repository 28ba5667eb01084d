# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Looks at an image through several windows and makes one list of robots of what they show."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.base import Detections, Detector, Image, detect_all
from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.windows import Window
from aerial_gnss_ros.detection.yolo import iou

_EDGE_PX = 2.0  # a box this close to an inner edge of its window is taken as cut off by it
_SLACK_PX = 8.0  # a window that shows a box with so much around it has seen all of it
_SAME_IOU = 0.3  # two windows place the same robot at least this well
_PART = 0.5  # a cut box that lies so much within another one is a part of it
_LEFT, _TOP, _RIGHT, _BOTTOM = range(4)


@dataclass
class Piece:
    """A box as one window shows it.

    Attributes:
        corners: (4,) left, top, right, bottom, pixels of the whole image.
        score: 0 to 1.
        class_id: index of the class.
        window: index of the window; -1: of several, joined.
        cut: (4,) for left, top, right, bottom whether the window's edge cuts it off.
    """

    corners: NDArray[np.float64]
    score: float
    class_id: int
    window: int
    cut: NDArray[np.bool_]

    @property
    def whole(self) -> bool:
        """Whether no edge cuts it."""
        return not bool(self.cut.any())


def look(
    detector: Detector, image: Image, windows: Sequence[Window]
) -> tuple[list[Piece], dict[str, float]]:
    """Return what each window shows, and the milliseconds of each stage over all of them."""
    size = (image.shape[1], image.shape[0])
    pieces: list[Piece] = []
    spent: Counter[str] = Counter()
    parts = [window.of(image) for window in windows]
    for index, (window, found) in enumerate(zip(windows, detect_all(detector, parts), strict=True)):
        for stage, milliseconds in found.timings_ms.items():
            spent[stage] += milliseconds  # type: ignore[assignment]  # Counter adds floats too
        corners = found.xyxy + np.array([window.left, window.top] * 2)
        near = np.abs(corners - window.corners) <= _EDGE_PX
        cut = near & window.inner_edges(size)
        pieces += [
            Piece(corners[i], float(found.scores[i]), int(found.class_ids[i]), index, cut[i])
            for i in range(len(found))
        ]
    return pieces, dict(spent)


def merge(pieces: Sequence[Piece], windows: Sequence[Window]) -> list[Piece]:
    """Return each robot once, best score first.

    A robot that several windows show whole is taken from where its score is best. One that an edge
    cuts is dropped where another window shows more of it, or shows the place and no robot there;
    two parts that face each other across an overlap become one. What is left cut is as it was seen.
    """
    kept: list[Piece] = []
    for piece in sorted(pieces, key=lambda p: (not p.whole, -p.score)):
        for i, other in enumerate(kept):
            if other.class_id != piece.class_id or other.window == piece.window:
                continue
            if _faces(piece, other):
                kept[i] = _joined(piece, other)
                break
            if _same(piece, other):
                break
        else:
            kept.append(piece)
    kept = [piece for piece in kept if piece.whole or not _seen_whole(piece, windows)]
    return sorted(kept, key=lambda p: -p.score)


def reconsidered(
    pieces: Sequence[Piece], image: Image, second: SecondLook, score_threshold: float
) -> list[Piece]:
    """Return the pieces that a second look leaves, best score first; cut ones keep their score.

    Args:
        pieces: what the windows show, merged.
        image: (height, width, 3) blue, green, red, all of it.
        second: looks at the whole ones.
        score_threshold: pieces below are dropped.
    """
    whole = sorted((piece for piece in pieces if piece.whole), key=lambda p: -p.score)
    corners = np.array([piece.corners for piece in whole], dtype=np.float64).reshape(-1, 4)
    scores = second.scores(
        image, centre_and_size(corners), np.array([piece.score for piece in whole], np.float64)
    )
    judged = [replace(piece, score=float(s)) for piece, s in zip(whole, scores, strict=True)]
    kept = [*judged, *(piece for piece in pieces if not piece.whole)]
    return sorted(
        (piece for piece in kept if piece.score >= score_threshold), key=lambda p: -p.score
    )


def centre_and_size(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return boxes (n, 4) as centre, width and height."""
    return np.hstack([(corners[:, :2] + corners[:, 2:]) / 2, corners[:, 2:] - corners[:, :2]])


def detections(
    pieces: Sequence[Piece], like: Sequence[str], most: int, timings_ms: dict[str, float]
) -> Detections:
    """Return pieces, best first, as detections.

    Args:
        pieces: to report.
        like: names of the classes.
        most: at most this many.
        timings_ms: milliseconds per stage.
    """
    chosen = pieces[:most]
    corners = np.array([piece.corners for piece in chosen], dtype=np.float64).reshape(-1, 4)
    return Detections(
        centre_and_size(corners),
        np.array([piece.score for piece in chosen], dtype=np.float64),
        np.array([piece.class_id for piece in chosen], dtype=np.int64),
        tuple(like),
        timings_ms,
    )


def _same(piece: Piece, other: Piece) -> bool:
    if float(iou(piece.corners[None], other.corners[None])[0, 0]) > _SAME_IOU:
        return True
    return not piece.whole and _shared(piece.corners, other.corners) > _PART * _area(piece.corners)


def _faces(piece: Piece, other: Piece) -> bool:
    """Return whether two cut boxes are two ends of one robot."""
    if _shared(piece.corners, other.corners) <= 0.0:
        return False
    for first, second in ((piece, other), (other, piece)):
        for low, high, across in ((_LEFT, _RIGHT, _TOP), (_TOP, _BOTTOM, _LEFT)):
            if first.cut[high] and second.cut[low] and _level(first, second, across):
                return True
    return False


def _level(a: Piece, b: Piece, low: int) -> bool:
    """Return whether two boxes lie at the same height (`low` _TOP) or column (_LEFT)."""
    starts, ends = (
        sorted((a.corners[low], b.corners[low])),
        sorted((a.corners[low + 2], b.corners[low + 2])),
    )
    return bool(ends[0] - starts[1] > _PART * (ends[1] - starts[0]))


def _joined(a: Piece, b: Piece) -> Piece:
    corners = np.hstack(
        [np.minimum(a.corners, b.corners)[:2], np.maximum(a.corners, b.corners)[2:]]
    )
    # A side of the whole is cut where the part that makes it is.
    own = np.where(np.abs(a.corners - corners) <= np.abs(b.corners - corners), a.cut, b.cut)
    return Piece(corners, max(a.score, b.score), a.class_id, -1, own)


def _seen_whole(piece: Piece, windows: Sequence[Window]) -> bool:
    """Return whether another window shows all of the box and some water round it."""
    for index, window in enumerate(windows):
        edges = window.corners
        room = np.hstack([piece.corners[:2] - edges[:2], edges[2:] - piece.corners[2:]])
        if index != piece.window and bool((room >= _SLACK_PX).all()):
            return True
    return False


def _shared(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    sides = np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2])
    return float(np.clip(sides, 0.0, None).prod())


def _area(corners: NDArray[np.float64]) -> float:
    return float((corners[2:] - corners[:2]).prod())
