# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which tracks have hits enough to be robots, and under which names they go on.

A track is confirmed by its hits if they came in at least half of the images since the first of
them: a robot is seen more often than not, a glint is not. In images full of false boxes it takes
as many more as it takes to believe that no track got its own by chance. One inside the gate of a
robot out of sight goes on under that robot's name (`reidentification`). Not so if one image showed
both: what is seen beside a robot is not that robot.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.config.processing import TracksConfig
from aerial_gnss_ros.core.faults.formation import TUNING as FORMATION
from aerial_gnss_ros.core.faults.formation import Formation
from aerial_gnss_ros.core.filter.joint_filter import JointFilter
from aerial_gnss_ros.core.geometry.local_map import LocalMap
from aerial_gnss_ros.core.identity.encounters import Encounters
from aerial_gnss_ros.core.identity.label_ambiguity import Position, exchange_probabilities
from aerial_gnss_ros.core.identity.labels import ConfirmedTrack, Labels
from aerial_gnss_ros.core.identity.reidentification import (
    Reidentification,
    Returns,
    duplicate_tracks,
)
from aerial_gnss_ros.core.identity.return_position import VelocityLikelihood
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.models.motion_model import manoeuvre_covariance
from aerial_gnss_ros.core.numerics.gaussian import gate_threshold, mahalanobis
from aerial_gnss_ros.core.tracker.confirmation_rule import ConfirmationRule
from aerial_gnss_ros.core.values.estimates import State

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ConfirmationTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    expected_false_tracks: float = 0.05
    """Tracks of false boxes alone that may be expected among those confirmed by an image.
    Judged."""


TUNING = ConfirmationTuning()


class TrackConfirmation:
    """Confirms tracks and names them.

    Args:
        joint: where robots are.
        identity: gives names.
        encounters: keeps doubts about them.
        rules: what confirms a track.

    Attributes:
        rule: measurements that confirm a track, and within what time.
    """

    def __init__(
        self,
        joint: JointFilter,
        identity: Labels,
        encounters: Encounters,
        rules: TracksConfig,
    ) -> None:
        self._filter = joint
        self._identity = identity
        self._encounters = encounters
        self.rule = ConfirmationRule(rules)
        self._threshold = gate_threshold(rules.gate_probability)
        self._reacquisition = Reidentification(joint.motion, self._threshold, rules.coast_s)
        self.reset()

    def reset(self) -> None:
        """Forget all images."""
        self._reacquisition.reset()
        self.rule.reset()
        self._images: deque[int] = deque()
        self._first_ns = 2**63 - 1

    def note(self, stamp_ns: int) -> None:
        """Take in that there is an image."""
        self.rule.note(stamp_ns)
        while self._images and stamp_ns - self._images[0] > self.rule.window_ns:
            self._images.popleft()
        self._images.append(stamp_ns)
        self._first_ns = min(self._first_ns, stamp_ns)

    @property
    def images(self) -> int:
        """How many images came within the time in which a track's hits must come."""
        return len(self._images)

    def ready(self, tracks: list[Track], stamp_ns: int, lasting: bool = False) -> list[int]:
        """Return the rows of tracks that can get a name.

        Args:
            tracks: all of them.
            stamp_ns: of the image, ns.
            lasting: whether they must have lasted `tracks.confirm_window_s`.
        """
        lasting = lasting or any(track.rejected for track in tracks)
        begun_ns = stamp_ns - (self.rule.window_ns if lasting else 0)
        found = [row for row, track in enumerate(tracks) if self._is_ready(track, begun_ns)]
        if not found:
            return found
        new = sum(track.state is State.TENTATIVE for track in tracks)
        return [
            row
            for row in found
            if len(tracks[row].hits) == 1
            or new * tracks[row].clutter_probability < TUNING.expected_false_tracks
        ]

    def are_back(
        self, tracks: list[Track], ready: list[int], boxes: int, once: bool = False
    ) -> bool:
        """Return whether robots that were not where they should be come back together.

        Args:
            tracks: all of them.
            ready: rows of those that could get a name.
            boxes: of the image; half of the robots with names that it may show must be back.
            once: whether to where they were before all of them seemed to move (`Track.once`).
        """
        away = [
            row
            for row, track in enumerate(tracks)
            if track.state is State.COASTING and bool(track.previous_label) is once
        ]
        if not away or not ready:
            return False
        offsets, spread = self._apart(away, ready)
        squared, _ = mahalanobis(offsets.reshape(-1, 2), spread.reshape(-1, 2, 2))
        near = (squared <= self._threshold).reshape(len(away), len(ready)).any(axis=1)
        return 2 * int(near.sum()) >= min(sum(bool(track.robot_id) for track in tracks), boxes)

    def formation_match(
        self, tracks: list[Track], ready: list[int], names: set[str]
    ) -> tuple[dict[int, int], Formation] | None:
        """Return which tracks are robots that are all elsewhere, by how they lie to one another.

        Args:
            tracks: all of them.
            ready: rows of those that could get a name.
            names: of the robots that were in view when none was where it should be.

        Returns:
            By row of a track that of the robot, and the formation; None where it does not tell.
        """
        old = [
            row
            for row, track in enumerate(tracks)
            if track.robot_id in names and track.state is State.COASTING and not track.leaving_view
        ]
        if min(len(old), len(ready)) < FORMATION.least_robots:
            return None
        classes = [[tracks[a].class_id == tracks[b].class_id for b in ready] for a in old]
        more = manoeuvre_covariance(self._filter.speeds(old))
        more = more if more.ndim == 2 else more[:, None]
        found = self._filter.formation(old, ready, more, np.array(classes, dtype=bool))
        if found is None:
            return None
        return {ready[j]: old[i] for i, j in found.pairs}, found

    def at_home(self, tracks: list[Track], found: dict[int, int]) -> bool:
        """Return whether all that were found are where they were before they seemed to move.

        Args:
            tracks: all of them.
            found: by row of a track that of the robot.
        """
        old = {
            track.previous_label: row for row, track in enumerate(tracks) if track.previous_label
        }
        pairs = [(old.get(tracks[robot].robot_id), row) for row, robot in found.items()]
        rows = [row for row, _ in pairs if row is not None]
        if len(rows) < len(pairs):
            return False
        offsets, spread = self._apart(rows, [row for _, row in pairs])
        every = np.arange(len(rows))
        squared, log_det = mahalanobis(offsets.reshape(-1, 2), spread.reshape(-1, 2, 2))
        squared, log_det = squared.reshape(len(rows), -1), log_det.reshape(len(rows), -1)
        # Where the names would be at home the other way round, formation and places contradict.
        likeliest = linear_sum_assignment(squared + log_det)[1]
        inside = squared[every, every] <= self._threshold
        return bool(inside.all() and (likeliest == every).all())

    def displaced(self, tracks: list[Track], found: dict[int, int]) -> float:
        """Return how far robots are from where they were before they seemed to move, m².

        Of the robot that is the farthest.

        Args:
            tracks: all of them.
            found: by row of a track that of the robot.
        """
        old = {
            track.previous_label: row for row, track in enumerate(tracks) if track.previous_label
        }
        first = [old.get(tracks[robot].robot_id, robot) for robot in found.values()]
        offsets = self._filter.mean[list(found), :2] - self._filter.mean[first, :2]
        return float(np.sum(offsets**2, axis=1).max())

    def regroup(self, tracks: list[Track], found: dict[int, int], moved: bool) -> set[int]:
        """Let tracks go on under the names of the robots that they are.

        Those that are elsewhere keep their old tracks, without names, should they come back.

        Args:
            tracks: all of them.
            found: by row of a track that of the robot.
            moved: whether they are elsewhere, so that the old places tell nothing of the new ones.

        Returns:
            The rows that are no longer needed.
        """
        for row, old in found.items():
            tracks[row].inherit_label(tracks[old])
            tracks[row].state = State.CONFIRMED
            tracks[row].label_pending = False
            if moved:
                tracks[old].previous_label, tracks[old].robot_id = tracks[old].robot_id, ""
            else:
                self._merge(old, row)
        if not moved:
            return set(found.values())
        # Of several old places of a robot the first one counts: that was before any doubt.
        names = [track.previous_label for track in tracks]
        return {old for old in found.values() if names.count(names[old]) > 1}

    def confirm(
        self,
        tracks: list[Track],
        ready: list[int],
        stamp_ns: int,
        height: float,
        local: LocalMap,
        told: bool = True,
    ) -> set[int]:
        """Name tracks; return the rows that they replace.

        Args:
            tracks: all of them.
            ready: rows of those that can get a name.
            stamp_ns: of the image, ns.
            height: of the camera above the water, m.
            local: the map.
            told: whether robots that are found again tell that the camera has not turned; not if
                most of them are missing.
        """
        folded = self._fold(tracks, ready)
        ready = [row for row in ready if row not in folded]
        came = self._resume(tracks, ready, stamp_ns, height)
        for row in ready:
            tracks[row].label_pending = row in came.waiting
        ready = [row for row in ready if row not in came.waiting]
        unknown = [row for row in ready if row not in came.found]
        names = self._identity.assign([self._sighting(tracks[row], row) for row in unknown], local)
        for row, name in zip(unknown, names, strict=True):
            tracks[row].robot_id = name
        for row, old in came.found.items():
            tracks[row].inherit_label(tracks[old])
        self._record_alternatives(tracks, came)
        for row, old in came.found.items():
            self._merge(old, row, told)
        for row in ready:
            tracks[row].state = State.CONFIRMED
        self._report_ended(tracks, came)
        return {*came.found.values(), *came.ended, *folded}

    def _report_ended(self, tracks: list[Track], came: Returns) -> None:
        """Say which names have ended."""
        for old in sorted(came.ended):
            likely = {p: tracks[new].robot_id for new, p in came.label_probabilities[old].items()}
            p = max(likely)
            self._filter.log.add(
                f"{tracks[old].robot_id} came up with others, and which it is nobody can tell: "
                f"its name ends. It is {likely[p]} with a probability of {p:.2f}."
            )

    def _record_alternatives(self, tracks: list[Track], came: Returns) -> None:
        """Let it be known whose the names of robots that came up may be instead."""
        called = {row: track.robot_id for row, track in enumerate(tracks)}
        exchanges = [
            exchange_probabilities(one, other, p) for (one, other), p in came.other.items()
        ]
        for law in [came.label_probabilities, *exchanges]:
            self._encounters.update_ambiguity(
                {called[a]: {called[b]: p for b, p in of.items() if p} for a, of in law.items()}
            )
        for row, share in came.unknown.items():
            old = came.found[row]
            spot = Position(self._filter.mean[old, :2], self._filter.covariance[old, :2, :2])
            self._encounters.note_departure(tracks[row].robot_id, spot, share)

    def _merge(self, old: int, new: int, told: bool = True) -> None:
        """Let a track know where the robot was that it turned out to be, which may have swerved."""
        self._filter.inflate_velocities(
            np.array([old]), self._filter.speeds([old]), MOTION_MODEL.swerve_s
        )
        self._filter.merge(old, new, told)

    def _fold(self, tracks: list[Track], ready: list[int]) -> set[int]:
        """Make one of tracks without names that are of one robot; return the rows that go."""
        if len(ready) < 2:
            return set()
        pairs = duplicate_tracks(tracks, ready, self._apart(ready, ready), self._threshold)
        for new, old in pairs.items():
            self._merge(old, new)
            tracks[new].absorb(tracks[old])
        return set(pairs.values())

    def _is_ready(self, track: Track, begun_ns: int) -> bool:
        """Return whether a track can get a name; it must have begun by then."""
        if track.state is not State.TENTATIVE or len(track.hits) < self.rule.hits:
            return False
        if track.rejected or track.first_seen_ns > begun_ns:
            return False
        since = sum(image >= track.hits[0] for image in self._images)
        return 2 * len(track.hits) >= since

    def _resume(
        self, tracks: list[Track], ready: list[int], stamp_ns: int, height: float
    ) -> Returns:
        """Return which new tracks are which robots out of sight."""
        away = [row for row, track in enumerate(tracks) if track.robot_id]
        if not away:
            return Returns()
        return self._reacquisition.decide(
            tracks, away, ready, self._apart(away, ready), self._velocity_likelihood(ready),
            stamp_ns, height, self._identity.newcomers((stamp_ns - self._first_ns) * 1e-9),
        )  # fmt: skip

    def _apart(self, old: list[int], new: list[int]) -> tuple[Array, Array]:
        """Return offsets (n, m, 2) between tracks, which may have swerved, and covariances."""
        offsets, spread = self._filter.separations(np.array(old), np.array(new))
        more = manoeuvre_covariance(self._filter.speeds(old))
        return offsets, spread + (more if more.ndim == 2 else more[:, None])

    def _velocity_likelihood(self, rows: list[int]) -> VelocityLikelihood:
        """Return how tracks without names swim, by their boxes."""
        velocities, spread = self._filter.mean[rows, 2:], self._filter.covariance[rows, 2:, 2:]
        return VelocityLikelihood.of(velocities, spread, self._filter.speeds(rows))

    def _sighting(self, track: Track, row: int) -> ConfirmedTrack:
        position, covariance = self._filter.mean[row, :2], self._filter.covariance[row, :2, :2]
        return ConfirmedTrack(track.class_id, track.last_seen_ns, position, covariance)
