# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The tracker: which detection is which robot, and the life of a track.

A detection that no track claims begins a tentative track. `confirm_hits` measurements within
`confirm_window_s` confirm it (`confirmation`): only then it has a name and is published. A
confirmed robot that an image does not show coasts; after `coast_s` unseen it is lost and its name
is used up.

A robot unseen for longer than `confirm_window_s` is not updated by a single detection: its gate is
wide by then, and one false box inside it would tear it away. Detections there begin a tentative
track, and when that is confirmed inside the gate, it goes on under the coasting robot's name.

Where robots are, and how well that is known, is the business of the joint filter (`joint`). Its
gate compares what is known relative to one another: an error that robot and detection share through
the platform costs nothing, while a drone that flies round a robot with a wrong compass, so that the
same error points the other way, does not lose it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.gating import CandidatePairs
from aerial_gnss_ros.core.association.image_tracks import ImageTracks
from aerial_gnss_ros.core.association.matcher import Matcher
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.faults.consistency import InnovationMonitor
from aerial_gnss_ros.core.faults.noise_level import Innovation
from aerial_gnss_ros.core.filter.joint_filter import JointFilter
from aerial_gnss_ros.core.geometry.local_map import LocalMap
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.georeferencing.measurements import Measurements, inside_any, measurements
from aerial_gnss_ros.core.identity.encounters import Encounters
from aerial_gnss_ros.core.identity.label_ambiguity import Position
from aerial_gnss_ros.core.identity.labels import Labels
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.models.platform_model import named_errors
from aerial_gnss_ros.core.numerics.gaussian import gate_threshold
from aerial_gnss_ros.core.tracker.box_account import BoxAccount, Settled
from aerial_gnss_ros.core.tracker.confirmation import TrackConfirmation
from aerial_gnss_ros.core.tracker.fork import Fork
from aerial_gnss_ros.core.tracker.protocol import TrackUpdate
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import RobotEstimate, State
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Cause

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class TrackerTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    max_tentative: int = 300
    """Tentative tracks kept at once: a frame full of false boxes must not stop the program.
    Judged."""
    soon_ns: int = 1_000_000_000
    """A moment for which boxes may be where no robots can be, ns. Judged."""


TUNING = TrackerTuning()


class Tracker:
    """Associates points on the water with robots and filters each robot (see the module)."""

    def __init__(
        self, config: EstimatorConfig, identity: Labels, log: Events | None = None
    ) -> None:
        self.filter = JointFilter(config, log)
        self._coast_ns = round(config.tracks.coast_s * 1e9)
        self._coast_of_class = {
            name: round(config.robot_class(name).coast_s * 1e9) for name, _ in config.classes
        }
        threshold = gate_threshold(config.tracks.gate_probability)
        self._matcher = Matcher(self.filter, threshold, config.tracks.confirm_window_s)
        self._encounters = Encounters(self.filter)
        self._naming = TrackConfirmation(self.filter, identity, self._encounters, config.tracks)
        self._picture = ImageTracks(
            config.noise.value("box_center_px"), self.filter.motion.speed_sigma
        )
        self._account = BoxAccount()
        self.tracks: list[Track] = []
        self._identity = identity
        self._local: LocalMap | None = None
        self._stamp_ns: int | None = None
        self.reset()

    def reset(self) -> None:
        """Forget all tracks."""
        self.end()
        self.tracks = []
        self.filter.reset()
        self._encounters.reset()
        self._naming.reset()
        self._picture.reset()
        self._stamp_ns = None
        self._water_altitude = np.nan
        self._height = np.nan
        self._matcher.scene_mismatch = False
        self._fork: Fork | None = None
        self._went_back = False
        self._lost_ns: int | None = None
        self._lost_names: set[str] = set()

    def update(self, frame: PosedFrame, points: WaterPoints, local: LocalMap) -> TrackUpdate:
        """Take in one image (see `Tracking`)."""
        self._local = local
        self._height = frame.pose.height
        self._water_altitude = frame.pose.altitude - self._height
        stamp_ns = frame.detections.stamp_ns
        self._naming.note(stamp_ns)
        self._matcher.fresh_s = self._naming.rule.window_ns * 1e-9
        seen = measurements(frame, points, local, self.filter.noise.level)
        passed = 0.0 if self._stamp_ns is None else (stamp_ns - self._stamp_ns) * 1e-9
        self._advance(stamp_ns)
        usable = self.filter.update_camera(frame, local)
        self._choose(stamp_ns)
        if not usable:
            self._picture.followed(frame.detections)
            unused = points.valid
            return TrackUpdate(self._estimates(stamp_ns), {}, unused, np.zeros_like(unused))
        if self.filter.orientation_jumped:
            self._matcher.expect_mismatch()
        confused = self._matcher.scene_mismatch
        rows, columns = self._associate(seen, stamp_ns)
        if self._matcher.scene_mismatch and self._is_as_before(seen, stamp_ns):
            rows, columns = self._associate(seen, stamp_ns)
        rows, columns = self._uncontradicted(frame.detections, seen, rows, columns)
        rows, columns, refused, newly = self._correct(seen, rows, columns, stamp_ns)
        self._update_ambiguity(rows, newly, stamp_ns, passed)
        if confused and not self._matcher.scene_mismatch:
            self._reject_unlabelled(stamp_ns)
        started = self._start(seen, np.concatenate([columns, refused]), frame.detections)
        measured = dict(zip(rows.tolist(), seen.index[columns].tolist(), strict=True)) | started
        self._note(measured, frame.detections)
        self._label(measured, frame, unexplained=not len(seen.index))
        updated = self._confirm(len(seen.index), local, stamp_ns)
        gated, too_fast = np.zeros((2, len(frame.detections)), dtype=bool)
        gated[seen.index] = True
        gated[list(measured.values())] = False
        gated[seen.index[refused]] = False
        too_fast[seen.index[refused]] = True
        names = {self.tracks[row].robot_id: index for row, index in measured.items()}
        names.pop("", None)
        stray = {row for row, one in enumerate(self.tracks) if one.rejected and not one.robot_id}
        stray -= {row for row, one in enumerate(self.tracks) if one.previous_label}
        self._drop(updated | stray)
        return TrackUpdate(
            self._estimates(stamp_ns), names, gated, too_fast, named_errors(*self.filter.platform)
        )

    def _associate(self, seen: Measurements, stamp_ns: int) -> tuple[Indices, Indices]:
        """Decide whose boxes an image shows; return rows and columns that belong together."""
        able = self._matcher.gate(self.tracks, seen, stamp_ns)
        if able is None:
            return np.zeros(0, np.intp), np.zeros(0, np.intp)
        self._note_innovations(able, stamp_ns)
        decided = self._matcher.assign(self.tracks, able, len(seen.index), stamp_ns)
        for row, strain in decided.innovation_ratios.items():
            self.tracks[row].innovation_ratio = strain
        for row, share in decided.chances.items():
            self.tracks[row].clutter_probability *= share
        for row in decided.near_misses:
            self.tracks[row].near_misses += 1
        self.filter.monitor.update_matches(decided.matched, decided.outside)
        for rows, speeds in decided.inflations:
            self.filter.inflate_velocities(rows, speeds, MOTION_MODEL.swerve_s)
        pairs, claimed = able.pairs, decided.claimed
        self.filter.update_reacquired(
            pairs.rows[claimed], pairs.offsets[claimed], pairs.spread[claimed]
        )
        return decided.rows, decided.columns

    def _note_innovations(self, able: CandidatePairs, stamp_ns: int) -> None:
        """Take in how far the boxes of robots in view are from where they are expected."""
        offsets, spread = able.pairs.offsets.tolist(), able.pairs.spread.tolist()
        share = 1.0 / self.filter.noise.level
        seen: list[tuple[Innovation, ...]] = []
        for k in able.nearest():
            (east, north), ((a, b), (_, d)) = offsets[k], spread[k]
            one = Innovation(stamp_ns, east, north, (share * a, share * b, share * d))
            track = self.tracks[able.rows[k]]
            track.innovations = (*track.innovations[-2:], one)
            seen.append(track.innovations)
        self.filter.noise.update(seen)

    def _choose(self, stamp_ns: int) -> None:
        """Keep robots as they are when telemetry jumps, and go on from there when it is back."""
        if self._fork is not None and not self._fork.holds(stamp_ns):
            self._fork = None
        if self.filter.began:
            self._fork = self._fork or self._forked(stamp_ns)
            self._fork.jumped = True
        if self.filter.back and self._fork is not None:
            self._go_back(self._fork)

    def _forked(self, stamp_ns: int) -> Fork:
        return Fork.of(stamp_ns, self.tracks, self.filter.groups)

    def _is_as_before(self, seen: Measurements, stamp_ns: int) -> bool:
        """Take in an image that robots do not explain; return whether those of before do.

        Args:
            seen: its boxes.
            stamp_ns: of it, ns.
        """
        if self._fork is None:
            self._fork = self._forked(stamp_ns)
        pairs = self.filter.compare_with(self._fork.groups, seen, self._matcher.threshold)
        if not self._fork.take(pairs, len(seen.index), self._matcher.threshold):
            return False
        self._go_back(self._fork)
        return True

    def _go_back(self, fork: Fork) -> None:
        """Forget what was seen since a fork, which stays until nothing contradicts robots."""
        self._fork = fork.again()
        self._drop(set(range(len(self.tracks))))
        self.tracks = fork.tracks
        self.filter.take_back(fork.groups)
        unnamed = fork.unnamed
        self.tracks = [track for track in self.tracks if track.robot_id]
        self.filter.drop(np.array(unnamed, np.intp))
        for track in self.tracks:
            track.state = State.COASTING
        self.filter.ambiguity.note_return()
        self._matcher.scene_mismatch, self._lost_ns = False, None
        self._went_back = True

    def settled(self) -> Settled:
        """Return what has been decided of boxes since this was asked last (see `Tracking`)."""
        return self._account.drain()

    def end(self) -> None:
        """Decide on all boxes (see `Tracking`)."""
        stamp_ns = self._stamp_ns or 0
        window_ns = self._naming.rule.window_ns
        self._end([one for one in self.tracks if stamp_ns - one.first_seen_ns > window_ns])
        self._account.end(self.tracks)

    def _end(self, tracks: list[Track]) -> None:
        """Decide on the boxes of tracks that had their time."""
        pace = self._naming.rule
        self._account.end(tracks, pace.hits, self._naming.images, self._matcher.scene_mismatch)

    def _note(self, measured: dict[int, int], boxes: DetectionFrame) -> None:
        """Take in which boxes measured or began which tracks."""
        centers = boxes.centers.tolist()
        for row, index in measured.items():
            self._account.note(self.tracks[row], boxes.stamp_ns, centers[index])

    def _uncontradicted(
        self, boxes: DetectionFrame, seen: Measurements, rows: Indices, columns: Indices
    ) -> tuple[Indices, Indices]:
        """Return the pairs of an assignment but for robots that the picture shows elsewhere.

        While images have wrong poses, or none, one robot's box may lie where another robot is
        expected.
        """
        labels = self._picture.expected(boxes)
        if not labels:
            return rows, columns
        names = [self.tracks[row].robot_id for row in rows]
        indices = seen.index[columns].tolist()
        kept = [
            not name or index not in labels or not labels[index].contradicts(name)
            for name, index in zip(names, indices, strict=True)
        ]
        return rows[kept], columns[kept]

    def _label(self, measured: dict[int, int], frame: PosedFrame, unexplained: bool) -> None:
        """Let new tracks know what the picture says of which robots they are.

        Robots that were gone back to are nowhere yet; the tracks that were given up for them knew
        until the last image which is which, and the picture goes on from there.

        Args:
            measured: boxes by row of the track that they measured or began.
            frame: the image.
            unexplained: whether no box lies on the water: the pose must be wrong.
        """
        named = {
            index: self.tracks[row].robot_id
            for row, index in measured.items()
            if self.tracks[row].robot_id
        }
        boxes = frame.detections
        if not named and (unexplained or self._matcher.scene_mismatch or self._went_back):
            labels = self._picture.followed(boxes)
        else:
            labels = self._picture.measured(boxes, frame.camera, frame.pose.height, named)
        self._went_back = False
        for row, index in measured.items():
            track = self.tracks[row]
            if index in labels and not track.robot_id and track.labels is None:
                track.labels = labels[index]

    @property
    def monitor(self) -> InnovationMonitor:
        """How well boxes fall where they are expected (see `Tracking`)."""
        return self.filter.monitor

    def coast(
        self, stamp_ns: int, boxes: DetectionFrame | None = None
    ) -> tuple[RobotEstimate, ...]:
        """Return the predicted robots at an image without a pose (see `Tracking`)."""
        self._advance(stamp_ns)
        if boxes is not None:
            self._picture.followed(boxes)
        return self._estimates(stamp_ns)

    def check(self) -> None:
        """Check that all numbers are finite and within bounds (see `Tracking`)."""
        self.filter.check()

    def _advance(self, stamp_ns: int) -> None:
        """Predict all tracks to an image and drop those unseen for too long."""
        if self._stamp_ns is not None:
            passed = (stamp_ns - self._stamp_ns) * 1e-9
            self.filter.predict(passed)
            if self._fork is not None:
                self.filter.predict_with(self._fork.groups, passed)
        self._stamp_ns = stamp_ns
        waiting = [track.first_seen_ns for track in self.tracks if track.label_pending]
        came = min(waiting, default=stamp_ns)  # for what waits, robots stay until it is decided
        gone = set()
        for row, track in enumerate(self.tracks):
            confirmed = track.state is not State.TENTATIVE
            coast_ns = self._coast_of_class.get(track.class_id, self._coast_ns)
            patience = coast_ns if confirmed else self._naming.rule.window_ns
            if confirmed:
                track.state = State.COASTING
            if (came if confirmed else stamp_ns) - track.last_seen_ns > patience:
                track.state = State.LOST
                gone.add(row)
        self._drop(gone)

    def _drop(self, rows: set[int]) -> None:
        if rows:
            self._end([self.tracks[row] for row in rows])
            kept = [row for row in range(len(self.tracks)) if row not in rows]
            self.tracks = [self.tracks[row] for row in kept]
            self.filter.drop(np.array(sorted(rows), np.intp))

    def _correct(
        self, seen: Measurements, rows: Indices, columns: Indices, stamp_ns: int
    ) -> tuple[Indices, Indices, Indices, int]:
        """Take in measurements.

        Returns:
            Rows that were corrected, with which columns, the columns that were refused, and to how
            many robots with names that had not been refused a box since they were seen.
        """
        columns = columns.copy()
        named = [i for i, row in enumerate(rows.tolist()) if self.tracks[row].robot_id]
        boxes = columns[named]
        columns[named] = boxes[
            self._encounters.update(
                [self.tracks[rows[i]] for i in named],
                rows[named],
                seen.positions[boxes],
                seen.white[boxes],
                stamp_ns,
            )
        ]
        impossible = self.filter.correct(seen, rows, columns)
        refused, newly = columns[:0], 0
        if len(impossible):
            fast = np.isin(rows, impossible)
            rows, columns, refused = rows[~fast], columns[~fast], columns[fast]
            for row in impossible:
                newly += bool(self.tracks[row].robot_id) and not self.tracks[row].rejected
                self.tracks[row].rejected = True
        velocities, edges = self.filter.mean[:, 2:], seen.edge.tolist()
        spread = self.filter.covariance[:, 2:, 2:]
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
            swims = velocities[row], spread[row]
            self.tracks[row].update(stamp_ns, self._naming.rule.window_ns, *swims, edges[column])
        return rows, columns, refused, newly

    def _reject_unlabelled(self, stamp_ns: int) -> None:
        """Give up what was only seen while robots were not where they should be."""
        for track in self.tracks:
            if not track.robot_id and not track.label_pending and track.last_seen_ns < stamp_ns:
                track.rejected, track.rejection_cause = True, Cause.LOST_PLATFORM

    def _update_ambiguity(self, rows: Indices, refused: int, stamp_ns: int, passed: float) -> None:
        """Take in whether robots explain an image's boxes: one or two cannot outvote a camera.

        Args:
            rows: that were corrected.
            refused: number of robots with names to which their boxes were refused.
            stamp_ns: of the image, ns.
            passed: time since the last one, s.
        """
        named = [self.tracks[row] for row in rows if self.tracks[row].robot_id]
        lost = self._matcher.scene_mismatch or (refused and refused >= len(named))
        if lost and self._lost_ns is None:
            self._lost_ns = stamp_ns
            self._lost_names = {
                track.robot_id
                for track in self.tracks
                if stamp_ns - track.last_seen_ns < TUNING.soon_ns
            }
        if self._fork is not None:
            doubt = self.filter.ambiguity
            calm = self._lost_ns is None and not doubt.apart and not doubt.covariance.any()
            self._fork.calm_s = self._fork.calm_s + passed if calm else 0.0
        if self._lost_ns is None:
            return
        if lost or not named:
            self.filter.update_ambiguity(passed)
            return
        # What moved robots within a moment, so that they are found again, shows in velocities.
        soon = stamp_ns - self._lost_ns < TUNING.soon_ns
        old = sum(
            track.first_seen_ns < self._lost_ns or (soon and track.robot_id in self._lost_names)
            for track in named
        )
        over = 2 * old > len(named)
        self.filter.update_ambiguity(0.0, over=over)
        if over:
            self._drop_unverified()
        self._lost_ns = None

    def _start(self, seen: Measurements, columns: Indices, frame: DetectionFrame) -> dict[int, int]:
        """Begin a track for each measurement left over; return detection indices by row.

        A second box on a robot that has one already (its centre lies in that box, and the class is
        the same) would only follow the first: it begins nothing and counts as gated, and so does
        what exceeds `TUNING.max_tentative`. The best scores come first.
        """
        if len(columns) == len(seen.index):
            return {}
        room = TUNING.max_tentative - sum(track.state is State.TENTATIVE for track in self.tracks)
        used = seen.index[columns].tolist()
        begun: list[int] = []
        taken = set(columns.tolist())
        left = [column for column in range(len(seen.index)) if column not in taken]
        for column in sorted(left, key=lambda item: -frame.scores[seen.index[item]]):
            index = int(seen.index[column])
            if len(begun) < room and not inside_any(frame, index, used):
                begun.append(column)
                used.append(index)
        first = len(self.tracks)
        self.filter.begin(seen, np.array(begun, np.intp))
        for column in begun:
            stamp_ns, edge = frame.stamp_ns, bool(seen.edge[column])
            track = Track(str(seen.class_ids[column]), stamp_ns, stamp_ns, hits=deque([stamp_ns]))
            track.entered_view = track.leaving_view = edge
            self.tracks.append(track)
        return {first + i: int(seen.index[column]) for i, column in enumerate(begun)}

    def _confirm(self, boxes: int, local: LocalMap, stamp_ns: int) -> set[int]:
        """Name the tracks that have hits enough; return the rows that they replace."""
        ready = self._naming.ready(self.tracks, stamp_ns)
        if self._matcher.scene_mismatch:
            regrouped = self._regroup(ready)
            if regrouped is not None:
                return regrouped
        self._restore_labels(ready, boxes)
        back = not self._matcher.scene_mismatch or self._naming.are_back(self.tracks, ready, boxes)
        if not back:
            ready = self._naming.ready(self.tracks, stamp_ns, lasting=True)
        if not ready:
            return set()
        if self._matcher.scene_mismatch and back:
            self._drop_unverified()
        self._matcher.scene_mismatch = False
        known = {track.robot_id for track in self.tracks}
        replaced = self._naming.confirm(self.tracks, ready, stamp_ns, self._height, local, back)
        if not back or self.filter.ambiguity.covariance.any():
            for row in ready:
                self.tracks[row].unverified = self.tracks[row].robot_id not in known
        self._account.confirm(self.tracks)
        return replaced

    def _drop_unverified(self) -> None:
        """Give up what was confirmed while robots were elsewhere and is not in view: they are back.

        Its place is that of boxes that were wrong.
        """
        for track in self.tracks:
            if track.unverified and track.state is State.COASTING:
                track.robot_id, track.rejected = "", True
            track.unverified = False

    def _restore_labels(self, ready: list[int], boxes: int) -> None:
        """Give robots their old places again where boxes show them there, and nowhere else.

        Args:
            ready: rows of tracks that have hits enough.
            boxes: of the image.
        """
        if any(track.robot_id and track.state is State.CONFIRMED for track in self.tracks):
            return
        if not self._naming.are_back(self.tracks, ready, boxes, once=True):
            return
        for track in self.tracks:
            if track.previous_label:
                for other in self.tracks:
                    if other.robot_id == track.previous_label:
                        other.robot_id, other.rejected = "", True
                track.robot_id, track.previous_label = track.previous_label, ""
        self.filter.note_return()
        self._drop_unverified()

    def _regroup(self, ready: list[int]) -> set[int] | None:
        """Name tracks by how they lie to one another where all robots are elsewhere.

        Args:
            ready: rows of tracks that have hits enough.

        Returns:
            The rows that they replace; None where their formation does not tell.
        """
        regrouped = self._naming.formation_match(self.tracks, ready, self._lost_names)
        if regrouped is None:
            return None
        found, formation = regrouped
        self._matcher.scene_mismatch = False
        self.filter.update_ambiguity(0.0, over=not formation.moved)
        if not formation.moved:
            self._drop_unverified()
        if formation.moved and self._naming.at_home(self.tracks, found):
            self.filter.note_return()
            self._drop_unverified()
        elif formation.moved:
            away = self._naming.displaced(self.tracks, found)
            self.filter.note_displacement(formation.turn, formation.spread, away)
        self._lost_ns = None
        replaced = self._naming.regroup(self.tracks, found, formation.moved)
        self._account.confirm(self.tracks)
        return replaced

    def _estimates(self, stamp_ns: int) -> tuple[RobotEstimate, ...]:
        named = [row for row, track in enumerate(self.tracks) if track.robot_id]
        if not named or self._local is None:
            return ()
        named.sort(key=lambda row: self.tracks[row].robot_id)
        mean, covariance = self.filter.mean, self.filter.covariance
        self.filter.add_fault_covariances(covariance)
        if named != list(range(len(mean))):
            mean, covariance = mean[named], covariance[named]
        names = [self.tracks[row].robot_id for row in named]
        if self._encounters.ambiguous:
            spots = {
                name: Position(mean[i, :2].copy(), covariance[i, :2, :2].copy())
                for i, name in enumerate(names)
            }
            for name, more in self._encounters.ambiguity_covariances(spots).items():
                covariance[names.index(name), :2, :2] += more
        if self._fork is not None:  # either of the two may be right
            rows = {name: i for i, name in enumerate(names)}
            for name, apart in self._fork.apart(rows, mean[:, :2]).items():
                covariance[rows[name], :2, :2] += np.outer(apart, apart)
        latitude, longitude = (values.tolist() for values in self._local.places(mean[:, :2]))
        altitude = float(self._water_altitude)
        estimates = tuple(
            RobotEstimate(
                stamp_ns=stamp_ns,
                robot_id=track.robot_id,
                class_id=track.class_id,
                state=track.state,
                latitude=latitude[i],
                longitude=longitude[i],
                altitude=altitude,
                position=mean[i, :2],
                velocity=mean[i, 2:],
                covariance=covariance[i],
                last_seen_ns=track.last_seen_ns,
            )
            for i, track in enumerate(self.tracks[row] for row in named)
        )
        self._identity.remember(estimates)
        return estimates
