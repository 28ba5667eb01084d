# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Selects the boxes of an image by score and class."""

from __future__ import annotations

import math

from aerial_gnss_ros.core.config.processing import DetectionsConfig
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Reason, Rejection

MAX_USUAL_BOXES, MAX_USUAL_FACTOR = 30, 3.0
"""Number of boxes, and factor on the usual number, above which boxes cannot all be robots."""
MEMORY_IMAGES = 30

UNKNOWN_BOXES = 10
"""Number of boxes of unknown classes without any other, above which it is reported."""


class DetectionFilter:
    """Refuses boxes by score and class, and reports implausible settings.

    Args:
        config: of the detections.
        log: receives warnings.

    Attributes:
        min_score: boxes below are refused; may be changed while running.
        classes: names that are robots, empty for all; likewise.
    """

    def __init__(self, config: DetectionsConfig, log: Events) -> None:
        self.min_score = config.min_score
        self.classes = config.classes
        self._log = log
        self._counts = BoxCountMonitor()
        self._unknown = UnknownClassMonitor()

    def reasons(self, frame: DetectionFrame) -> list[Reason | None]:
        """Return for each box the reason of its refusal, or None."""
        found = refusals(frame, self.min_score, self.classes)
        count = found.count(None)
        usual = self._counts.update(count)
        if usual is not None:
            self._log.counts["images_crowded"] += 1
            self._log.warn_once(
                "crowd",
                f"An image has {count} boxes, earlier ones about {usual:.0f}: nearly all must be "
                "false. Boxes not seen again are never confirmed; if it continues, raise "
                "detections.min_score.",
            )
        unknown = self._unknown.update(frame.class_ids, found)
        if unknown:
            self._log.warn_once(
                "strangers",
                f"All boxes so far are of class {_listed(unknown)} and refused as wrong_class: "
                f"detections.classes is {_listed(self.classes)}; enter the class names that the "
                "detector gives to robots.",
            )
        return found


class BoxCountMonitor:
    """Detects an image with far more boxes than earlier ones."""

    def __init__(self) -> None:
        self._usual: float | None = None

    def update(self, count: int) -> float | None:
        """Update with an image's number of boxes; return the usual one if this is far more."""
        usual = count if self._usual is None else self._usual
        self._usual = usual + (count - usual) / MEMORY_IMAGES
        return usual if count > MAX_USUAL_BOXES + MAX_USUAL_FACTOR * usual else None


class UnknownClassMonitor:
    """Detects that no box has a robot's class."""

    def __init__(self) -> None:
        self._count = 0
        self._names: dict[str, None] = {}
        self._known = False

    def update(self, names: tuple[str, ...], reasons: list[Reason | None]) -> tuple[str, ...]:
        """Update with an image's boxes; return their classes if none is a robot's.

        Args:
            names: class of each box.
            reasons: of their refusal, or None.
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
    """Return for each box the reason of its refusal, or None.

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
    found: list[Reason | None] = []
    for center, size, score, name in rows:
        # One part that is not finite is enough.
        finite = math.isfinite(center[0] + center[1] + (size[0] + size[1]) + score)
        if not (finite and min(size) >= 0.0):
            found.append(Reason.BAD_DETECTIONS)
        elif score < min_score:
            found.append(Reason.LOW_SCORE)
        elif classes and name not in classes:
            found.append(Reason.WRONG_CLASS)
        else:
            found.append(None)
    return found


def rejections(frame: DetectionFrame, reasons: list[Reason | None]) -> tuple[Rejection, ...]:
    """Return the refused boxes in the order of the frame."""
    if not any(reasons):
        return ()
    return tuple(
        Rejection(frame.stamp_ns, reason, float(center[0]), float(center[1]))
        for reason, center in zip(reasons, frame.centers, strict=True)
        if reason is not None
    )


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(map(repr, names))
