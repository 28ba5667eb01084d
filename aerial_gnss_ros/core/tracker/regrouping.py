# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Re-identification of robots that are all displaced at once, by their formation.

Whether the robots moved or the camera is wrong is not decided here. Tracks found elsewhere inherit
the labels; the old tracks are kept for a while without (`Track.previous_label`), in case all robots
return.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.faults.formation import TUNING as FORMATION
from aerial_gnss_ros.core.faults.formation import Formation
from aerial_gnss_ros.core.models.motion_model import manoeuvre_covariance
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis
from aerial_gnss_ros.core.numerics.linear_assignment import linear_sum_assignment
from aerial_gnss_ros.core.tracker.track_table import TrackTable
from aerial_gnss_ros.core.values.estimates import State

Array = NDArray[np.float64]


class Regrouping:
    """Re-identifies displaced robots.

    Args:
        table: the tracks.
        threshold: squared Mahalanobis distance at the edge of a gate.
    """

    def __init__(self, table: TrackTable, threshold: float) -> None:
        self._table = table
        self._threshold = threshold

    def are_back(self, ready: list[int], boxes: int, previous: bool = False) -> bool:
        """Return whether displaced robots reappear together at their old positions.

        Args:
            ready: rows of tracks that can be labelled.
            boxes: number of boxes of the image; half of the robots that it may show must be back.
            previous: whether to the positions before the displacement (`Track.previous_label`).
        """
        tracks = self._table.tracks
        away = [
            row
            for row, track in enumerate(tracks)
            if track.state is State.COASTING and bool(track.previous_label) is previous
        ]
        if not away or not ready:
            return False
        offsets, spread = self._table.separations(away, ready)
        squared, _ = mahalanobis(offsets.reshape(-1, 2), spread.reshape(-1, 2, 2))
        near = (squared <= self._threshold).reshape(len(away), len(ready)).any(axis=1)
        return 2 * int(near.sum()) >= min(sum(bool(track.robot_id) for track in tracks), boxes)

    def formation_match(
        self, ready: list[int], labels: set[str]
    ) -> tuple[dict[int, int], Formation] | None:
        """Return which tracks are which displaced robots, by their formation.

        Args:
            ready: rows of tracks that can be labelled.
            labels: of the robots in view when the displacement began.

        Returns:
            Row of the robot by row of the track, and the formation; None if ambiguous.
        """
        tracks, joint = self._table.tracks, self._table.filter
        old = [
            row
            for row, track in enumerate(tracks)
            if track.robot_id in labels and track.state is State.COASTING and not track.leaving_view
        ]
        if min(len(old), len(ready)) < FORMATION.least_robots:
            return None
        classes = [[tracks[a].class_id == tracks[b].class_id for b in ready] for a in old]
        more = manoeuvre_covariance(joint.speeds(old))
        more = more if more.ndim == 2 else more[:, None]
        found = joint.formation(old, ready, more, np.array(classes, dtype=bool))
        if found is None:
            return None
        return {ready[j]: old[i] for i, j in found.pairs}, found

    def at_home(self, found: dict[int, int]) -> bool:
        """Return whether all matched robots are at their positions before the displacement.

        Args:
            found: row of the robot by row of the track.
        """
        tracks = self._table.tracks
        old = self._previous()
        pairs = [(old.get(tracks[robot].robot_id), row) for row, robot in found.items()]
        rows = [row for row, _ in pairs if row is not None]
        if len(rows) < len(pairs):
            return False
        offsets, spread = self._table.separations(rows, [row for _, row in pairs])
        every = np.arange(len(rows))
        squared, log_det = mahalanobis(offsets.reshape(-1, 2), spread.reshape(-1, 2, 2))
        squared, log_det = squared.reshape(len(rows), -1), log_det.reshape(len(rows), -1)
        # If the positions fit other labels, formation and positions contradict each other.
        likeliest = linear_sum_assignment(squared + log_det)[1]
        inside = squared[every, every] <= self._threshold
        return bool(inside.all() and (likeliest == every).all())

    def displacement(self, found: dict[int, int]) -> float:
        """Return the squared distance of the robots from their previous positions, m².

        Of the robot displaced farthest.

        Args:
            found: row of the robot by row of the track.
        """
        tracks, (mean, _) = self._table.tracks, self._table.filter.moments()
        old = self._previous()
        first = [old.get(tracks[robot].robot_id, robot) for robot in found.values()]
        offsets = mean[list(found), :2] - mean[first, :2]
        return float(np.sum(offsets**2, axis=1).max())

    def _previous(self) -> dict[str, int]:
        """Return the rows of the old tracks of displaced robots, by label."""
        tracks = enumerate(self._table.tracks)
        return {track.previous_label: row for row, track in tracks if track.previous_label}

    def relabel(self, found: dict[int, int], moved: bool) -> set[int]:
        """Let tracks inherit the labels of the robots that they continue.

        Displaced robots keep their old tracks, without labels, in case they return.

        Args:
            found: row of the robot by row of the track.
            moved: whether they are displaced, so that old positions say nothing about new ones.

        Returns:
            The rows that are no longer needed.
        """
        tracks = self._table.tracks
        for row, old in found.items():
            tracks[row].inherit_label(tracks[old])
            tracks[row].state = State.CONFIRMED
            tracks[row].label_pending = False
            if moved:
                tracks[old].previous_label, tracks[old].robot_id = tracks[old].robot_id, ""
            else:
                self._table.merge(old, row)
        if not moved:
            return set(found.values())
        # Of several old positions of a robot the first one counts, from before any ambiguity.
        labels = [track.previous_label for track in tracks]
        return {old for old in found.values() if labels.count(labels[old]) > 1}

    def restore_labels(self) -> None:
        """Restore robots at their old positions."""
        tracks = self._table.tracks
        for track in tracks:
            if not track.previous_label:
                continue
            for other in tracks:
                if other.robot_id == track.previous_label:
                    other.robot_id, other.rejected = "", True
            track.robot_id, track.previous_label = track.previous_label, ""
        self._table.filter.note_return()
        self._table.give_up_unverified()
