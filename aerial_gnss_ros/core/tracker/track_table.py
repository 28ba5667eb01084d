# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The track table: a record of each track, and its state in the filter; both use the same rows.

Records hold what images have shown of a track (`Track`), the filter its position and covariance
(`JointFilter`). Association, identity and fault tests read them and return decisions, which only
the tracker applies, through this table.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.decision import Association
from aerial_gnss_ros.core.association.gating import CandidatePairs
from aerial_gnss_ros.core.association.track import TUNING as TRACK
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.faults.noise_level import Innovations
from aerial_gnss_ros.core.filter.innovation import misfit
from aerial_gnss_ros.core.filter.joint_filter import JointFilter
from aerial_gnss_ros.core.georeferencing.measurements import Measurements, inside_any
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.models.motion_model import manoeuvre_covariance
from aerial_gnss_ros.core.tracker.fork import Fork
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import State

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class TrackTableTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    max_tentative: int = 300
    """Greatest number of tentative tracks: an image full of clutter must not stop the program.
    Judged."""


TUNING = TrackTableTuning()


class TrackTable:
    """Tracks by row.

    Args:
        joint: the filter, without robots.

    Attributes:
        tracks: the records.
        filter: the arrays.
    """

    def __init__(self, joint: JointFilter) -> None:
        self.filter = joint
        self.tracks: list[Track] = []
        self._origin_ns: int | None = None

    def reset(self) -> None:
        """Forget all tracks."""
        self.tracks = []
        self._origin_ns = None
        self.filter.reset()

    def start(
        self, seen: Measurements, measured: dict[int, int], used: Indices, frame: DetectionFrame
    ) -> None:
        """Start a track for each unassociated measurement, best scores first.

        A second box of a robot that already has one (its centre lies in that box, and the class is
        the same) would only duplicate it: it starts nothing and counts as gated, as do boxes beyond
        `TUNING.max_tentative`.

        Args:
            seen: the image's measurements.
            measured: detection by row of the track that it measured; extended by new tracks.
            used: measurements that are not left over.
            frame: the image's detections.
        """
        tracks = self.tracks
        room = TUNING.max_tentative - sum(track.state is State.TENTATIVE for track in tracks)
        taken, indices = set(used.tolist()), seen.index[used].tolist()
        left = [column for column in range(len(seen.index)) if column not in taken]
        begun: list[int] = []
        for column in sorted(left, key=lambda item: -frame.scores[seen.index[item]]):
            index = int(seen.index[column])
            if len(begun) < room and not inside_any(frame, index, indices):
                measured[len(tracks) + len(begun)] = index
                begun.append(column)
                indices.append(index)
        stamp_ns = frame.stamp_ns
        self.filter.begin(seen, np.array(begun, np.intp))
        for column in begun:
            edge = bool(seen.edge[column])
            track = Track(str(seen.class_ids[column]), stamp_ns, stamp_ns, hits=(stamp_ns,))
            track.entered_view = track.leaving_view = edge
            self.tracks.append(track)

    def drop(self, rows: set[int]) -> None:
        """Remove tracks; later rows move up."""
        self.tracks = [track for row, track in enumerate(self.tracks) if row not in rows]
        self.filter.drop(np.array(sorted(rows), np.intp))

    def restore(self, fork: Fork) -> None:
        """Continue with the labelled robots of a fork, coasting; drop all others."""
        self.filter.restore(fork.groups)
        self.filter.drop(np.array(fork.unnamed, np.intp))
        self.tracks = [track for track in fork.tracks if track.robot_id]
        for track in self.tracks:
            track.state = State.COASTING
        self.filter.ambiguity.note_return()

    def note_innovations(self, able: CandidatePairs, seen: Measurements, stamp_ns: int) -> None:
        """Take in the innovations of the robots in view."""
        pairs, near = able.pairs, able.nearest
        if not near:
            return
        if self._origin_ns is None:  # stamps themselves are too large for a float
            self._origin_ns = stamp_ns
        found: list[Innovations] = []
        passed, share = float(stamp_ns - self._origin_ns), 1.0 / self.filter.noise.level
        chosen = pairs.offsets.take(near, axis=0).tolist(), pairs.spread.take(near, axis=0).tolist()
        stated = (share * seen.white.trace(axis1=1, axis2=2)).tolist()
        for k, (east, north), ((a, b), (_, d)) in zip(near, *chosen, strict=True):
            told = stated[able.columns[k]] if k in able.lone else math.nan
            now = (passed, east, north, a, b, d, told)
            track = self.tracks[able.rows[k]]
            track.innovations = track.innovations[7:] + now
            found.append(track.innovations)
        self.filter.noise.update(found)

    def in_view(self, stamp_ns: int) -> list[int]:
        """Return the rows of the robots that an image is expected to show."""
        return [
            row
            for row, track in enumerate(self.tracks)
            if track.robot_id and not track.leaving_view
            and stamp_ns - track.last_seen_ns <= TRACK.recent_ns
        ]  # fmt: skip

    def misfit(self, seen: Measurements, stamp_ns: int, threshold: float) -> float:
        """Return how badly boxes fit the robots in view, nats.

        Args:
            seen: the image's measurements.
            stamp_ns: of it, ns.
            threshold: squared Mahalanobis distance at the edge of a gate.
        """
        expected = self.in_view(stamp_ns)
        if not expected or not len(seen.index):
            return 0.5 * threshold * len(expected)
        return misfit(self.filter.compare(seen, threshold, 1.0), expected, threshold)

    def apply(self, decided: Association, able: CandidatePairs) -> None:
        """Apply the decisions of association other than the assignment."""
        tracks = self.tracks
        if decided.sentence:
            self.filter.log.add(decided.sentence)
        for row, share in decided.clutter_shares.items():
            tracks[row].clutter_probability *= share
        for row in decided.near_misses:
            tracks[row].near_misses += 1
        self.filter.monitor.update_matches(decided.matched, decided.outside)
        if decided.manoeuvred:
            rows = np.array(decided.manoeuvred, np.intp)
            self.filter.inflate_velocities(rows, self.filter.speeds(rows), MOTION_MODEL.swerve_s)
        if self.filter.ambiguity.active:
            pairs, claimed = able.pairs, decided.claimed
            self.filter.update_reacquired(
                pairs.rows[claimed], pairs.offsets[claimed], pairs.spread[claimed]
            )

    def update(
        self, seen: Measurements, rows: Indices, columns: Indices, stamp_ns: int, window_ns: int
    ) -> tuple[Indices, int]:
        """Update tracks with their measurements.

        Args:
            seen: the image's measurements.
            rows: (m,) of the tracks.
            columns: (m,) their measurements.
            stamp_ns: of the image, ns.
            window_ns: how long hits are kept, ns.

        Returns:
            The rows whose measurements are refused because they imply an impossible speed, and how
            many of these are labelled robots without an earlier refusal since they were last seen.
        """
        tracks, labelled = self.tracks, 0
        robots = np.array([bool(tracks[row].robot_id) for row in rows.tolist()], np.bool_)
        refused = self.filter.correct(seen, rows, columns, robots)
        for row in refused.tolist():
            labelled += bool(tracks[row].robot_id) and not tracks[row].rejected
            tracks[row].rejected = True
        mean, covariance = self.filter.moments()
        mean.flags.writeable = covariance.flags.writeable = False  # tracks keep views of them
        velocities, spread, edges = [*mean[:, 2:]], [*covariance[:, 2:, 2:]], seen.edge.tolist()
        both = np.square(mean[:, 2:])
        squares = (0.5 * (both[:, 0] + both[:, 1])).tolist()
        fast, habit_s = set(refused.tolist()), TRACK.habit_s
        tentative, confirmed = State.TENTATIVE, State.CONFIRMED
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
            if row in fast:
                continue
            track = tracks[row]
            if track.state is not tentative:
                track.state = confirmed
                since = min((stamp_ns - track.last_seen_ns) * 1e-9 / habit_s, 1.0)
                track.speed_history += since * squares[row]
                track.speed_history_count += since
            track.leaving_view, track.last_seen_ns = edges[column], stamp_ns
            track.velocity, track.velocity_spread = velocities[row], spread[row]
            hits = (*track.hits, stamp_ns)
            while stamp_ns - hits[0] > window_ns:
                hits = hits[1:]
            track.hits = hits
        return refused, labelled

    def merge(self, old: int, new: int, known: bool = True) -> None:
        """Merge a re-identified robot, which may have manoeuvred, into its new track.

        Args:
            old: row of the robot.
            new: row of the new track.
            known: whether its position is evidence about the camera's attitude.
        """
        self.filter.inflate_velocities(
            np.array([old]), self.filter.speeds([old]), MOTION_MODEL.swerve_s
        )
        self.filter.merge(old, new, known)

    def separations(self, old: list[int], new: list[int]) -> tuple[Array, Array]:
        """Return offsets (n, m, 2) between tracks and covariances that allow manoeuvres."""
        offsets, spread = self.filter.separations(np.array(old), np.array(new))
        more = manoeuvre_covariance(self.filter.speeds(old))
        return offsets, spread + (more if more.ndim == 2 else more[:, None])

    def give_up_unverified(self) -> None:
        """Drop robots confirmed during a scene mismatch and out of view, now that it is over.

        Their positions come from boxes with a wrong pose.
        """
        for track in self.tracks:
            if track.unverified and track.state is State.COASTING:
                track.robot_id, track.rejected = "", True
            track.unverified = False
