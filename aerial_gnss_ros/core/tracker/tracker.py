# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The tracker: association, confirmation, labels and the life of each track.

An unassociated detection starts a tentative track. `confirm_hits` measurements within
`confirm_window_s` confirm it (`confirmation`): then it is labelled and published. A confirmed robot
that an image does not show coasts; after `coast_s` without a detection it is lost, and its label is
not issued again.

A robot unseen for longer than `confirm_window_s` is not updated by a single detection: its gate is
wide by then, and clutter inside it would divert the track. Detections there start a tentative
track, which inherits the robot's label if re-identification decides so at its confirmation.

The joint filter holds robots and platform errors in one state. Its gate uses relative covariances:
an error common to robot and detection through the platform does not widen it, while a drone that
circles a robot with a wrong compass, so that the error reverses, does not lose it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from aerial_gnss_ros.core.association.image_tracks import ImageTracks
from aerial_gnss_ros.core.association.matcher import Matcher
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.faults.consistency import InnovationMonitor
from aerial_gnss_ros.core.filter.joint_filter import JointFilter
from aerial_gnss_ros.core.filter.recalibration import CalibrationChange
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.georeferencing.measurements import Measurements, measurements
from aerial_gnss_ros.core.georeferencing.size_fit import NO_SIZES, SizeFit
from aerial_gnss_ros.core.identity.encounters import Encounters
from aerial_gnss_ros.core.identity.labels import Box, Labels
from aerial_gnss_ros.core.numerics.gaussian import gate_threshold
from aerial_gnss_ros.core.references.candidates import Expected, below_camera
from aerial_gnss_ros.core.references.references import References
from aerial_gnss_ros.core.references.source import FilterSource
from aerial_gnss_ros.core.tracker.box_account import BoxAccount, Settled, box_masks
from aerial_gnss_ros.core.tracker.coasting import Coasting
from aerial_gnss_ros.core.tracker.confirmation import TrackConfirmation
from aerial_gnss_ros.core.tracker.gnss_jump_test import robots_tell_jump
from aerial_gnss_ros.core.tracker.image_evidence import ImageEvidence
from aerial_gnss_ros.core.tracker.image_update import ImageUpdate
from aerial_gnss_ros.core.tracker.labelling import Labelling
from aerial_gnss_ros.core.tracker.protocol import TrackUpdate
from aerial_gnss_ros.core.tracker.publication import published, with_white
from aerial_gnss_ros.core.tracker.recovery import Recovery
from aerial_gnss_ros.core.tracker.track_table import TrackTable
from aerial_gnss_ros.core.tracker.vanished_robots import VanishedRobots
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import PlatformError, RobotEstimate
from aerial_gnss_ros.core.values.events import Events


class Tracker:
    """Associates points on the water with robots and filters each robot (see the module)."""

    def __init__(
        self, config: EstimatorConfig, identity: Labels, log: Events | None = None
    ) -> None:
        self.table = TrackTable(JointFilter(config, log))
        self._searched = config.noise.value("latency_s") > 0.0
        self._known = config.references
        joint, threshold = self.table.filter, gate_threshold(config.tracks.gate_probability)
        self._matcher = Matcher(joint, threshold, config.tracks.confirm_window_s)
        self._encounters = Encounters(joint)
        self._confirmation = TrackConfirmation(
            self.table, identity, self._encounters, config.tracks, config.detections,
            self._matcher.clutter,
        )  # fmt: skip
        self._recovery = Recovery(self.table, self._matcher, threshold)
        self._image_tracks = ImageTracks(
            config.noise.value("box_center_px"), joint.motion.speed_sigma
        )
        self._image_evidence = ImageEvidence(self._image_tracks)
        self._image_update = ImageUpdate(
            self.table, self._matcher, self._encounters, self._image_evidence, self._recovery,
            self._confirmation.rule,
        )  # fmt: skip
        self._account = BoxAccount(self._confirmation.doubt)
        self._coasting = Coasting(self.table, self._confirmation, config)
        self._vanished = VanishedRobots(self.table, self._confirmation, self._coasting)
        self._labelling = Labelling(
            self.table, self._matcher, self._recovery, self._confirmation, self._account
        )
        self._references = References(FilterSource(joint), joint.log)
        self._with_white = config.updates.covariance_parts
        self._identity = identity
        self._local: LocalMap | None = None
        self._stamp_ns: int | None = None
        self.reset()

    def reset(self) -> None:
        """Forget all tracks."""
        self.end()
        self.table.reset()
        self._encounters.reset()
        self._references.reset()
        self._confirmation.reset()
        self._image_tracks.reset()
        self._recovery.reset()
        self._stamp_ns = None
        self._water_altitude = np.nan

    def update(self, frame: PosedFrame, points: WaterPoints, local: LocalMap) -> TrackUpdate:
        """Take in one image (see `Tracking`)."""
        joint, stamp_ns = self.table.filter, frame.detections.stamp_ns
        self._local, self._water_altitude = local, frame.pose.altitude - frame.pose.height
        passed = self._predict(stamp_ns, posed=True)
        seen = measurements(frame, points, local, joint.noise.level)
        threshold = self._matcher.threshold
        joint.update_camera(frame, lambda: robots_tell_jump(self.table, frame, seen, threshold))
        seen = seen.moved(-joint.trajectory.jumps.offset)
        self._recovery.forget_old(stamp_ns)
        if joint.jumped:
            joint.note_jump(not (len(seen.index) and self.table.in_view(stamp_ns)))
        if joint.orientation_jumped:
            self._matcher.mismatch.expect()
        return self._track(frame, seen, points.sizes, local, passed)

    def _track(
        self,
        frame: PosedFrame,
        seen: Measurements,
        sizes: SizeFit | None,
        local: LocalMap,
        passed: float,
    ) -> TrackUpdate:
        """Associate an image's boxes, update and confirm tracks, and publish.

        Args:
            frame: the image.
            seen: its measurements.
            sizes: of its boxes, where a length is stated for a class.
            local: the map.
            passed: time since the last image, s.
        """
        boxes, stamp_ns = frame.detections, frame.detections.stamp_ns
        mismatch, returned = self._matcher.mismatch.active, False
        assigned = self._image_update.assign(seen, boxes)
        if self._matcher.mismatch.active and self._recovery.explains(seen, stamp_ns):
            self._go_back()
            returned = True
            assigned = self._image_update.assign(seen, boxes)
        measured, refused = self._image_update.correct(seen, boxes, assigned, passed)
        if mismatch and not self._matcher.mismatch.active:
            self._recovery.reject_unlabelled(stamp_ns)
        if not (self._matcher.mismatch.active or self._recovery.fork):
            self._vanished.update(frame.camera, stamp_ns, passed)
        self._account.note(self.table.tracks, measured, boxes, sizes)
        masks = box_masks(seen, measured, refused, len(boxes.class_ids))
        unexplained = returned or self._matcher.mismatch.active or not len(seen.index)
        self._image_evidence.label(self.table.tracks, measured, frame, unexplained)
        gone = self._labelling.update(len(seen.index), frame.pose.height, local, stamp_ns)
        tracks = self.table.tracks
        names = {tracks[row].robot_id: box for row, box in measured.items() if tracks[row].robot_id}
        self._drop(gone)
        places = below_camera(frame.references, frame.pose, self.table.filter.log)
        expected = [Expected.of(one, frame.pose, local) for one in places]
        self._references.update(self.table.tracks, expected, stamp_ns)
        if self._references.in_view:
            self.table.filter.trajectory.jumps.confirm()
        estimates, platform = self._estimates(stamp_ns)
        fork, moored = self._recovery.fork, self.table.filter.laws.moored
        current = None if fork or moored is None else moored.current()
        corrects = dict(self._references.links)
        return TrackUpdate(estimates, names, *masks, platform, current, corrects)

    def reconfigure(self, config: EstimatorConfig, change: CalibrationChange) -> None:
        """Use another configuration from the next image on (see `Tracking`)."""
        self._coasting.reconfigure(config)
        joint, fork = self.table.filter, self._recovery.fork
        joint.reconfigure(config, [track.class_id for track in self.table.tracks])
        self._identity.reconfigure(config)
        self._confirmation.transients.min_score = config.detections.min_score
        self._confirmation.least_score = config.tracks.confirm_score
        for track in self.table.tracks:
            track.sizes = NO_SIZES  # against lengths that may have changed
        if change:
            joint.recalibrate(change, () if fork is None else fork.groups, self._searched)
            self._references.recalibrate(change)
        gone = [one.name for one in self._known if one not in config.references]
        self._references.forget(gone)
        self._known = config.references

    @property
    def classes(self) -> dict[str, str]:
        """Classes of the robots, by their labels."""
        return {one.robot_id: one.class_id for one in self.table.tracks if one.robot_id}

    def rename(self, names: Mapping[str, str]) -> None:
        """Give robots other labels: new ones by old ones; others stay."""
        for track in self.table.tracks:
            track.rename(names)
        self._encounters.rename(names)
        self._recovery.rename(names)
        self._references.rename(names)
        self._image_tracks.rename(names)

    def follow_references(self, links: Mapping[str, str]) -> None:
        """Note which robot each reference is that another tracker of the same boxes uses."""
        self._references.recognised = links

    def misfit(self, frame: PosedFrame, points: WaterPoints, local: LocalMap) -> float:
        """Return how badly an image's boxes fit the robots in view, nats (see `Tracking`)."""
        joint, stamp_ns = self.table.filter, frame.detections.stamp_ns
        self._predict(stamp_ns)
        joint.update_camera(frame)
        seen = measurements(frame, points, local, joint.noise.level)
        seen = seen.moved(-joint.trajectory.jumps.offset)
        return self.table.misfit(seen, stamp_ns, self._matcher.threshold)

    def settled(self) -> Settled:
        """Return the boxes decided since the last call (see `Tracking`)."""
        return self._account.drain()

    def keep_pending(self, boxes: set[Box]) -> set[Box]:
        """Leave the decision on other boxes to another tracker (see `Tracking`)."""
        return self._account.keep_pending(self.table.tracks, boxes)

    def end(self) -> None:
        """Decide on all boxes (see `Tracking`)."""
        stamp_ns, tracks = self._stamp_ns or 0, self.table.tracks
        window_ns = self._confirmation.rule.window_ns
        self._end([one for one in tracks if stamp_ns - one.first_seen_ns > window_ns])
        self._account.end(tracks)

    @property
    def monitor(self) -> InnovationMonitor:
        """Innovation statistics (see `Tracking`)."""
        return self.table.filter.monitor

    def coast(
        self, stamp_ns: int, boxes: DetectionFrame | None = None
    ) -> tuple[RobotEstimate, ...]:
        """Return the predicted robots at an image without a pose (see `Tracking`)."""
        self._predict(stamp_ns)
        if boxes is not None:
            self._image_tracks.followed(boxes)
        return self._estimates(stamp_ns)[0]

    def check(self) -> None:
        """Check that all numbers are finite and within bounds (see `Tracking`)."""
        self.table.filter.check()

    def _predict(self, stamp_ns: int, posed: bool = False) -> float:
        """Predict all tracks to an image and drop those unseen for too long.

        Args:
            stamp_ns: of the image, ns.
            posed: whether it has a pose: such images confirm tracks.

        Returns:
            Time since the image before, s.
        """
        if posed:
            self._confirmation.rule.note(stamp_ns)
        passed = 0.0 if self._stamp_ns is None else (stamp_ns - self._stamp_ns) * 1e-9
        if self._stamp_ns is not None:
            self.table.filter.predict(passed)
            self._recovery.predict(passed)
        self._stamp_ns = stamp_ns
        self._drop(self._coasting.update(stamp_ns))
        return passed

    def _estimates(
        self, stamp_ns: int
    ) -> tuple[tuple[RobotEstimate, ...], tuple[PlatformError, ...]]:
        """Return the labelled robots and the platform's errors as published."""
        if self._local is None:
            return (), ()
        altitude, fork = float(self._water_altitude), self._recovery.fork
        estimates, platform = published(
            self.table, self._encounters, fork, self._references, self._local, altitude, stamp_ns
        )
        if self._with_white:
            estimates = with_white(estimates, self.table)
        if estimates:
            self._identity.remember(estimates)
        return estimates, platform

    def _go_back(self) -> None:
        """Drop what was seen since the contradiction, and restore the fork."""
        self._end(self.table.tracks)
        self._recovery.go_back()
        self._image_tracks.keep_labels({track.robot_id for track in self.table.tracks})

    def _drop(self, rows: set[int]) -> None:
        """Drop tracks and refuse their pending boxes."""
        if rows:
            self._end([self.table.tracks[row] for row in rows])
            self.table.drop(rows)

    def _end(self, tracks: list[Track]) -> None:
        """Decide on the pending boxes of tracks that end."""
        rule, mismatch = self._confirmation.rule, self._matcher.mismatch.active
        self._account.end(tracks, rule.hits, len(rule.images), mismatch)
