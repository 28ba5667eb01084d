# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which boxes of an image are used at all."""

from __future__ import annotations

import math

from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.rejection import Reason, Rejection

MAX_USUAL_BOXES, MAX_USUAL_FACTOR = 30, 3.0
"""More boxes than these, the factor times the usual number, do not come with robots."""
MEMORY_IMAGES = 30

UNKNOWN_BOXES = 10
"""Boxes of classes that are no robots from which on it is no chance that no other came."""


class BoxCountMonitor:
    """Notices an image with far more boxes than those before it."""

    def __init__(self) -> None:
        self._usual: float | None = None

    def update(self, count: int) -> float | None:
        """Take in an image's number of boxes; return the usual one if this is far more."""
        usual = count if self._usual is None else self._usual
        self._usual = usual + (count - usual) / MEMORY_IMAGES
        return usual if count > MAX_USUAL_BOXES + MAX_USUAL_FACTOR * usual else None


class UnknownClassMonitor:
    """Notices that none of the boxes is of a class that is a robot."""

    def __init__(self) -> None:
        self._count = 0
        self._names: dict[str, None] = {}
        self._known = False

    def update(self, names: tuple[str, ...], reasons: list[Reason | None]) -> tuple[str, ...]:
        """Take in an image's boxes; return the classes that came when none of them is a robot's.

        Args:
            names: class of each box.
            reasons: why each is not used, or None.
        """
        if self._known or not names:
            return ()
        for name, reason in zip(names, reasons, strict=True):
            if reason is Reason.WRONG_CLASS:
                self._count += 1
                self._names[name] = None
            elif reason is None:
                self._known = True
        return tuple(self._names) if self._count >= UNKNOWN_BOXES and not self._known else ()


def refusals(
    frame: DetectionFrame, min_score: float, classes: tuple[str, ...]
) -> list[Reason | None]:
    """Return for each box why it is not used, or None.

    Args:
        frame: all boxes of one image.
        min_score: boxes below are refused.
        classes: names that are robots; empty for all.
    """
    rows = zip(
        frame.centers.tolist(),
        frame.sizes.tolist(),
        frame.scores.tolist(),
        frame.class_ids,
        strict=True,
    )
    return [
        _refusal(sum(center) + sum(size) + score, min(size), score, name, min_score, classes)
        for center, size, score, name in rows
    ]


def _refusal(
    total: float,
    size: float,
    score: float,
    name: str,
    min_score: float,
    classes: tuple[str, ...],
) -> Reason | None:
    if not (math.isfinite(total) and size >= 0.0):  # one part that is not finite is enough
        return Reason.BAD_DETECTIONS
    if score < min_score:
        return Reason.LOW_SCORE
    if classes and name not in classes:
        return Reason.WRONG_CLASS
    return None


def rejections(frame: DetectionFrame, reasons: list[Reason | None]) -> tuple[Rejection, ...]:
    """Return the refused boxes in the order of the frame."""
    if not any(reasons):
        return ()
    return tuple(
        Rejection(frame.stamp_ns, reason, float(center[0]), float(center[1]))
        for reason, center in zip(reasons, frame.centers, strict=True)
        if reason is not None
    )
