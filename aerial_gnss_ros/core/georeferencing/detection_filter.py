# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which boxes of an image are used at all."""

from __future__ import annotations

import math

from aerial_gnss_ros.core.config.processing import DetectionsConfig
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Reason, Rejection

MAX_USUAL_BOXES, MAX_USUAL_FACTOR = 30, 3.0
"""More boxes than these, the factor times the usual number, do not come with robots."""
MEMORY_IMAGES = 30

UNKNOWN_BOXES = 10
"""Boxes of classes that are no robots from which on it is no chance that no other came."""


class DetectionFilter:
    """Refuses boxes by score and class, and says when the detector's settings look wrong.

    Args:
        config: which boxes are used.
        log: where it is said.

    Attributes:
        min_score: boxes below are refused; may be changed while running.
    """

    def __init__(self, config: DetectionsConfig, log: Events) -> None:
        self.min_score = config.min_score
        self._classes = config.classes
        self._log = log
        self._counts = BoxCountMonitor()
        self._unknown = UnknownClassMonitor()

    def reasons(self, frame: DetectionFrame) -> list[Reason | None]:
        """Return for each box of an image why it is not used, or None."""
        found = refusals(frame, self.min_score, self._classes)
        count = found.count(None)
        usual = self._counts.update(count)
        if usual is not None:
            self._log.counts["images_crowded"] += 1
            self._log.warn_once(
                "crowd",
                f"An image has {count} boxes, those before it about {usual:.0f}: nearly all must "
                "be false. Those not seen again become no robots; if it goes on, raise "
                "detections.min_score.",
            )
        unknown = self._unknown.update(frame.class_ids, found)
        if unknown:
            self._log.warn_once(
                "strangers",
                f"All boxes so far are of class {_listed(unknown)} and refused as wrong_class: "
                f"detections.classes is {_listed(self._classes)}; put the names there that the "
                "detector gives to robots.",
            )
        return found


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
