# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a drone tells the fleet of one image: boxes, the camera's pose, and its own association.

A sighting has measurements, never positions: the fleet's filter uses each box once. Of the drone's
estimator it takes which box is which of its robots, and where that estimator doubts itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.faults.consistency import InnovationMonitor
from aerial_gnss_ros.core.filter.recalibration import CalibrationChange
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.identity.labels import Box
from aerial_gnss_ros.core.tracker.box_account import Settled
from aerial_gnss_ros.core.tracker.protocol import TrackUpdate
from aerial_gnss_ros.core.tracker.tracker import Tracker
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import RobotEstimate
from aerial_gnss_ros.core.values.reference_place import ReferencePlace

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sighting:
    """One image of one drone.

    Attributes:
        stamp_ns: of the image, ns.
        frame_id: of the image.
        camera: lens and image.
        pose: of the camera by telemetry; its stamp is the time of the scene.
        jump: (3,) East, North, Up by which the position has jumped and is not believed, m.
        believed: (2,) sum of the jumps that the drone has accepted, m.
        labels: (m,) the drone's names of the robots that boxes of this image measured; "" where it
            has not confirmed one yet.
        tracks: (m,) numbers of its tracks; a robot keeps its own until it is lost.
        class_ids: (m,) their classes.
        pixels: (m, 2) centres of these boxes, px; refraction taken out.
        doubt: (m, 2, 2) by how much the drone widens its own positions beyond its filter's
            covariance: possible faults, labels that may be exchanged, m².
        level: factor by which white noise is larger than stated.
        sizes: (m, 2) widths and heights of these boxes, to 0.1 px, or None. They and scores decide
            in the drone's own association, never in a filter: here they are for people and tools.
        scores: (m,) 0 to 1, to 0.001, or None.
        references: where references that move were at the time of the scene.
    """

    stamp_ns: int
    frame_id: str
    camera: CameraModel
    pose: CameraPose
    jump: Array
    believed: Array
    labels: tuple[str, ...]
    tracks: tuple[int, ...]
    class_ids: tuple[str, ...]
    pixels: Array
    doubt: Array
    level: float = 1.0
    sizes: Array | None = None
    scores: Array | None = None
    references: tuple[ReferencePlace, ...] = ()


class SightingTap:
    """A tracker that keeps a sighting of each image that it is given (see `Tracking`).

    Args:
        tracker: does the work.

    Attributes:
        sightings: of the images since the last `drain`.
    """

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker
        self.sightings: list[Sighting] = []

    def follow(self, tracker: Tracker) -> None:
        """Go on with another tracker: the estimator has begun anew."""
        self._tracker = tracker

    def drain(self) -> list[Sighting]:
        """Return the sightings since the last call."""
        found, self.sightings = self.sightings, []
        return found

    def update(self, frame: PosedFrame, points: WaterPoints, local: LocalMap) -> TrackUpdate:
        """Process one image with its pose."""
        update = self._tracker.update(frame, points, local)
        self.sightings.append(self._sighting(frame, points, update))
        return update

    def _sighting(self, frame: PosedFrame, points: WaterPoints, update: TrackUpdate) -> Sighting:
        table, boxes = self._tracker.table, frame.detections
        rows = {track.robot_id: row for row, track in enumerate(table.tracks) if track.robot_id}
        labels = sorted(update.measured)
        used = [(label, rows[label], update.measured[label]) for label in labels]
        used += [("", *one) for one in _tentative(table.tracks, boxes)]
        labels += [""] * (len(used) - len(labels))
        doubt = np.zeros((len(used), 2, 2))
        if update.measured:
            plain = table.filter.moments()[1]
            stated = {one.robot_id: one.covariance[:2, :2] for one in update.estimates}
            for k, label in enumerate(sorted(update.measured)):
                if label in stated:
                    doubt[k] = _positive_part(stated[label] - plain[rows[label], :2, :2])
        numbers = np.zeros(len(table.tracks), np.intp)
        for group in table.filter.groups:
            numbers[group.rows] = group.ids
        return Sighting(
            boxes.stamp_ns,
            boxes.frame_id,
            frame.camera,
            frame.pose,
            table.filter.trajectory.jumps.offset.copy(),
            table.filter.trajectory.jumps.believed.copy(),
            tuple(label for label, _, _ in used),
            tuple(numbers[[row for _, row, _ in used]].tolist()),
            tuple(boxes.class_ids[k] for _, _, k in used),
            points.pixels[[k for _, _, k in used]].reshape(-1, 2),
            doubt,
            table.filter.noise.level,
            np.round(boxes.sizes[[k for _, _, k in used]].reshape(-1, 2), 1),
            np.round(boxes.scores[[k for _, _, k in used]], 3),
            tuple(one for one in frame.references if one.moves),
        )

    def misfit(self, frame: PosedFrame, points: WaterPoints, local: LocalMap) -> float:
        """Return how badly an image's boxes fit, nats."""
        return self._tracker.misfit(frame, points, local)

    def reconfigure(self, config: EstimatorConfig, change: CalibrationChange) -> None:
        """Take over parameters that were changed in flight."""
        self._tracker.reconfigure(config, change)

    @property
    def monitor(self) -> InnovationMonitor:
        """Innovation statistics."""
        return self._tracker.monitor

    def coast(
        self, stamp_ns: int, boxes: DetectionFrame | None = None
    ) -> tuple[RobotEstimate, ...]:
        """Return the predicted robots at an image without a pose."""
        return self._tracker.coast(stamp_ns, boxes)

    def settled(self) -> Settled:
        """Return the boxes decided since the last call."""
        return self._tracker.settled()

    def keep_pending(self, boxes: set[Box]) -> set[Box]:
        """Leave the decision on other boxes to another tracker."""
        return self._tracker.keep_pending(boxes)

    def end(self) -> None:
        """Decide on all boxes."""
        self._tracker.end()

    def check(self) -> None:
        """Check that all numbers are finite and within bounds."""
        self._tracker.check()

    def reset(self) -> None:
        """Drop all tracks."""
        self._tracker.reset()


def _tentative(tracks: list[Track], boxes: DetectionFrame) -> list[tuple[int, int]]:
    """Return rows of tracks without a label that an image has measured, and their boxes."""
    centers = {center: k for k, center in enumerate(map(tuple, boxes.centers.tolist()))}
    found = []
    for row, track in enumerate(tracks):
        stamp_ns, *center = track.pending_boxes[-1] if track.pending_boxes else (-1,)
        if not track.robot_id and stamp_ns == boxes.stamp_ns:
            found.append((row, centers[tuple(center)]))
    return found


def _positive_part(matrix: Array) -> Array:
    """Return the positive semidefinite part of a symmetric matrix (2, 2)."""
    values, vectors = np.linalg.eigh(matrix)
    found: Array = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return found
