# SPDX-License-Identifier: Apache-2.0
"""Which boxes of an image are used at all."""

from __future__ import annotations

import math

from aerial_gnss_ros.core.rejection import Reason, Rejection
from aerial_gnss_ros.core.values import DetectionFrame

CROWD, CROWD_FACTOR = 30, 3.0
"""More boxes than these, the factor times the usual number, do not come with robots."""
MEMORY_IMAGES = 30


class Crowd:
    """Notices an image with far more boxes than those before it."""

    def __init__(self) -> None:
        self._usual: float | None = None

    def take(self, count: int) -> float | None:
        """Take in an image's number of boxes; return the usual one if this is far more."""
        usual = count if self._usual is None else self._usual
        self._usual = usual + (count - usual) / MEMORY_IMAGES
        return usual if count > CROWD + CROWD_FACTOR * usual else None


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
