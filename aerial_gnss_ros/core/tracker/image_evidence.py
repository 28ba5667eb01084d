# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Evidence of labels from tracking in the image, applied to tracks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.image_tracks import ImageTracks
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame

Indices = NDArray[np.intp]


class ImageEvidence:
    """Compares boxes that are tracked in the image plane with the tracks on the water.

    Args:
        image: tracks boxes in the image plane.
    """

    def __init__(self, image: ImageTracks) -> None:
        self._image = image

    def uncontradicted(
        self,
        tracks: list[Track],
        boxes: DetectionFrame,
        seen: Measurements,
        rows: Indices,
        columns: Indices,
    ) -> tuple[Indices, Indices]:
        """Drop pairs of an assignment that contradict tracking in the image.

        While images have wrong poses, or none, one robot's box may lie in another robot's gate.

        Args:
            tracks: all of them.
            boxes: all of the image.
            seen: the image's measurements.
            rows: (m,) of the tracks.
            columns: (m,) of their measurements.
        """
        if self._image.blind_ns is None:
            return rows, columns
        labels = self._image.expected(boxes)
        names = [tracks[row].robot_id for row in rows]
        indices = seen.index[columns].tolist()
        kept = [
            not name or index not in labels or not labels[index].contradicts(name)
            for name, index in zip(names, indices, strict=True)
        ]
        return rows[kept], columns[kept]

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
