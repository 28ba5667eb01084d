# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether the detector knows the classes to which references are bound."""

from __future__ import annotations

from collections.abc import Sequence

from aerial_gnss_ros.core.config.references import Reference
from aerial_gnss_ros.core.identity.label_format import class_token
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.events import Events

WAITS_S = 30.0
"""How long other boxes come before a class without any is reported, s: a reference may come into
view later. Judged."""


class ReferenceClasses:
    """Reports references of a class that no box has.

    Args:
        references: as configured.
        log: receives a sentence for each.
    """

    def __init__(self, references: Sequence[Reference], log: Events) -> None:
        self._waiting = {one.name: one.class_id for one in references}
        self._log = log
        self._first_ns: int | None = None
        self._seen: set[str] = set()

    def update(self, frame: DetectionFrame) -> None:
        """Take in an image's boxes."""
        if not self._waiting or not frame.class_ids:
            return
        self._first_ns = frame.stamp_ns if self._first_ns is None else self._first_ns
        self._seen.update(frame.class_ids)
        tokens = {class_token(name) for name in self._seen}
        for name, class_id in list(self._waiting.items()):
            if class_token(class_id) in tokens:
                del self._waiting[name]
        if (frame.stamp_ns - self._first_ns) * 1e-9 >= WAITS_S:
            self.end()

    def end(self) -> None:
        """Report those that are still waited for, of input that ends or lasts long enough."""
        if not self._seen:
            return
        seen = ", ".join(map(repr, sorted(self._seen)))
        for name, class_id in self._waiting.items():
            self._log.warn_once(
                f"class of {name} {class_id}",
                f"Reference {name} has not been seen: references.{name}.class is {class_id!r}, and "
                f"all boxes so far are of class {seen}. If it was in view, enter the class name "
                "that the detector gives it.",
            )
        self._waiting.clear()
