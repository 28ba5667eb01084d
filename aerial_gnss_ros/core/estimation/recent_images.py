# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The images of the last seconds, to be taken in again with another latency."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field

from aerial_gnss_ros.core.values.detection_frame import DetectionFrame


@dataclass(frozen=True)
class RecentImagesTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    kept_ns: int = 15_000_000_000
    """How long images are kept, ns: about as long as a latency takes to be found, and well within
    the minute of telemetry that is kept. Judged."""
    apart_ns: int = 190_000_000
    """Least time between two images that are kept, ns: of errors that last, more images tell hardly
    more. Judged."""


TUNING = RecentImagesTuning()


@dataclass(frozen=True)
class SeenImage:
    """An image that the published tracker has taken in.

    Attributes:
        frame: its boxes.
        measured: index of the box of each labelled robot; None: it had no pose.
        corrects: label of the robot that each used reference is.
    """

    frame: DetectionFrame
    measured: dict[str, int] | None
    corrects: Mapping[str, str] = field(default_factory=dict)


class RecentImages:
    """Keeps some images of the last seconds, at most 79.

    Attributes:
        images: the oldest first.
    """

    def __init__(self) -> None:
        self.images: deque[SeenImage] = deque()

    def add(self, image: SeenImage) -> None:
        """Keep an image, unless it follows the last kept one too closely; drop those too old."""
        kept, now_ns = self.images, image.frame.stamp_ns
        if kept and now_ns - kept[-1].frame.stamp_ns < TUNING.apart_ns:
            return
        kept.append(image)
        while now_ns - kept[0].frame.stamp_ns > TUNING.kept_ns:
            kept.popleft()
