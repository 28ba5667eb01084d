# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Evidence of labels from tracking in the image, applied to tracks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.image_tracks import ImageTracks
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class ImageEvidenceTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    excluded_cost: float = 100.0
    """Minus twice the log likelihood of what tracking in the image excludes. Judged."""


TUNING = ImageEvidenceTuning()


class ImageEvidence:
    """Compares boxes that are tracked in the image plane with the tracks on the water.

    Args:
        image: tracks boxes in the image plane.
    """

    def __init__(self, image: ImageTracks) -> None:
        self._image = image

    @property
    def blind(self) -> bool:
        """Whether images had no pose, or a wrong one, a moment ago."""
        return self._image.blind_ns is not None

    def cost(self, tracks: list[Track], boxes: DetectionFrame, seen: Measurements) -> Array:
        """Return minus twice the log likelihood (n, m) of n tracks' m measurements.

        It is `TUNING.excluded_cost` where the image clearly shows another robot.

        Args:
            tracks: all of them.
            boxes: all of the image, which has updated no robot yet.
            seen: its measurements.
        """
        labels = self._image.expected(boxes)
        found = np.zeros((len(tracks), len(seen.index)))
        rows = [row for row, track in enumerate(tracks) if track.robot_id]
        for column, index in enumerate(seen.index.tolist()):
            if index not in labels:
                continue
            one = labels[index]
            found[rows, column] = [
                TUNING.excluded_cost if one.contradicts(name) else -2.0 * math.log(one.factor(name))
                for name in (tracks[row].robot_id for row in rows)
            ]
        return found

    def label(
        self, tracks: list[Track], measured: dict[int, int], frame: PosedFrame, unexplained: bool
    ) -> None:
        """Give new tracks the evidence of their labels from tracking in the image.

        Args:
            tracks: all of them.
            measured: boxes by row of the track that they measured or started.
            frame: the image.
            unexplained: whether the image's boxes are no measurements of robots: none lies on the
                water, so the pose must be wrong; or few are where robots are expected; or the fork
                was restored, whose robots have no boxes yet. Until the last image the dropped
                tracks had the right labels, which tracking in the image continues.
        """
        boxes, named = frame.detections, {}
        for row, index in measured.items():
            if tracks[row].robot_id:
                named[index] = tracks[row].robot_id
        if not named and unexplained:
            labels = self._image.followed(boxes)
        else:
            labels = self._image.measured(boxes, frame.camera, frame.pose.height, named)
        if not labels:
            return
        for row, index in measured.items():
            track = tracks[row]
            if index in labels and not track.robot_id and track.label_evidence is None:
                track.label_evidence = labels[index]
