# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Interface between georeferenced images and a tracker; any implementation can be used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.faults.consistency import InnovationMonitor
from aerial_gnss_ros.core.filter.recalibration import CalibrationChange
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.identity.labels import Box
from aerial_gnss_ros.core.tracker.box_account import Settled
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import Current, PlatformError, RobotEstimate


@dataclass(frozen=True)
class TrackUpdate:
    """Result of one image.

    Attributes:
        estimates: confirmed and coasting robots, ordered by robot_id.
        measured: index of the detection that updated each confirmed robot, by robot_id.
        gated: (n,) True where a detection with a point neither updated nor started a track.
        too_fast: (n,) True where it was refused because it implies an impossible speed.
        platform: errors of the platform, if the tracker estimates them.
        current: with which some robots drift, if it is known.
        corrects: label of the robot that each reference is by which positions are corrected.
    """

    estimates: tuple[RobotEstimate, ...]
    measured: dict[str, int]
    gated: NDArray[np.bool_]
    too_fast: NDArray[np.bool_]
    platform: tuple[PlatformError, ...] = ()
    current: Current | None = None
    corrects: Mapping[str, str] = field(default_factory=dict)


class Tracking(Protocol):
    """Turns posed frames, in stamp order, into labelled robots."""

    def update(self, frame: PosedFrame, points: WaterPoints, local: LocalMap) -> TrackUpdate:
        """Process one image with its pose.

        Args:
            frame: boxes, camera and pose, for a joint filter.
            points: position of each box on the water, for a simple tracker.
            local: the frame `map`, the same from the first call to the last.
        """

    def misfit(self, frame: PosedFrame, points: WaterPoints, local: LocalMap) -> float:
        """Return the negative log likelihood of an image's boxes, nats; called on a copy only.

        Differences are log likelihood ratios of cameras or poses of the image.

        Args:
            frame: boxes, camera and pose.
            points: position of each box on the water, by itself.
            local: the frame `map`.
        """

    def reconfigure(self, config: EstimatorConfig, change: CalibrationChange) -> None:
        """Use another configuration from the next image on; robots keep their labels.

        Args:
            config: differs in parameters that may be changed in flight.
            change: of the calibration of pose, latency and camera; later images have the new one.
        """

    @property
    def monitor(self) -> InnovationMonitor:
        """Innovation statistics."""

    def coast(
        self, stamp_ns: int, boxes: DetectionFrame | None = None
    ) -> tuple[RobotEstimate, ...]:
        """Return the predicted robots at an image without a pose.

        Args:
            stamp_ns: of the image, ns.
            boxes: of the image, if they are real: labels can be kept by them.
        """

    def settled(self) -> Settled:
        """Return the boxes decided since the last call (see `BoxAccount`)."""

    def keep_pending(self, boxes: set[Box]) -> set[Box]:
        """Leave the decision on all pending boxes but some to another tracker.

        Args:
            boxes: those that it leaves to this one.

        Returns:
            Which of them are pending.
        """

    def end(self) -> None:
        """Decide on all boxes: the recording has ended."""

    def check(self) -> None:
        """Check that all numbers are finite and within bounds; called after every image.

        Raises:
            StateError: they are not.
        """

    def reset(self) -> None:
        """Drop all tracks; labels are not issued again."""
