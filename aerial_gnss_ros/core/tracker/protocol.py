# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The seam between one image's points and robots over time: any tracker that fits it will do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.faults.consistency import InnovationMonitor
from aerial_gnss_ros.core.geometry.local_map import LocalMap
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.tracker.box_account import Settled
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import PlatformError, RobotEstimate


@dataclass(frozen=True)
class TrackUpdate:
    """What one image did to the robots.

    Attributes:
        estimates: confirmed and coasting robots, ordered by robot_id.
        measured: index of the detection that measured each confirmed robot, by robot_id.
        gated: (n,) True where a detection with a point neither updated nor began a track.
        too_fast: (n,) True where it was refused its track, which it would have made too fast.
        platform: errors of the platform, where the tracker estimates them.
    """

    estimates: tuple[RobotEstimate, ...]
    measured: dict[str, int]
    gated: NDArray[np.bool_]
    too_fast: NDArray[np.bool_]
    platform: tuple[PlatformError, ...] = ()


class Tracking(Protocol):
    """Turns posed frames, in the order of their stamps, into robots that keep their names."""

    def update(self, frame: PosedFrame, points: WaterPoints, local: LocalMap) -> TrackUpdate:
        """Take in one image with its pose.

        Args:
            frame: boxes, camera and pose; a joint filter works on these.
            points: where each box lies on the water, taken singly; a first tracker works on these.
            local: the frame `map`, the same from the first call to the last.
        """

    def misfit(self, frame: PosedFrame, points: WaterPoints, local: LocalMap) -> float:
        """Return how badly an image's boxes fit the robots in view, nats; asked of a copy only.

        Differences tell how much likelier one camera or pose of the image is than another.

        Args:
            frame: boxes, camera and pose.
            points: where each box lies on the water, taken singly.
            local: the frame `map`.
        """

    @property
    def monitor(self) -> InnovationMonitor:
        """Tells how well boxes fall where they are expected."""

    def coast(
        self, stamp_ns: int, boxes: DetectionFrame | None = None
    ) -> tuple[RobotEstimate, ...]:
        """Return the predicted robots at an image that has no pose; nothing is measured.

        Args:
            stamp_ns: of the image, ns.
            boxes: that it shows, where they are those of a picture: names may be kept by them.
        """

    def settled(self) -> Settled:
        """Return what has been decided of boxes since this was asked last (see `BoxAccount`)."""

    def end(self) -> None:
        """Decide on all boxes: nothing more comes."""

    def check(self) -> None:
        """Check that all numbers are finite and within bounds; called after every image.

        Raises:
            StateError: they are not.
        """

    def reset(self) -> None:
        """Forget all tracks; names once given are not given again."""
