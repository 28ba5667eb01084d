# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recovery from a scene mismatch: most robots are not where they are expected.

Either telemetry is wrong now, or it was until now, or all robots have moved. So the robots are kept
as a fork (`Fork`) while the filter continues. Later images decide: boxes return to the robots' old
positions, or the robots are re-identified by their formation elsewhere (`Regrouping`), or new
tracks are confirmed.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.matcher import Matcher
from aerial_gnss_ros.core.association.track import TUNING as TRACK
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.tracker.fork import Fork
from aerial_gnss_ros.core.tracker.regrouping import Regrouping
from aerial_gnss_ros.core.tracker.track_table import TrackTable
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.rejection import Cause

Indices = NDArray[np.intp]


class Recovery:
    """Decides between the hypotheses of a scene mismatch.

    Args:
        table: the tracks.
        matcher: detects scene mismatches, and is reset when one is over.
        threshold: squared Mahalanobis distance at the edge of a gate.

    Attributes:
        fork: the robots before the contradiction, while they may be right.
        regrouping: re-identifies displaced robots by their formation.
    """

    def __init__(self, table: TrackTable, matcher: Matcher, threshold: float) -> None:
        self._table = table
        self._matcher = matcher
        self.regrouping = Regrouping(table, threshold)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.fork: Fork | None = None
        self._lost_ns: int | None = None
        self._lost_labels: set[str] = set()
        self._matcher.mismatch.end()

    def rename(self, names: Mapping[str, str]) -> None:
        """Give robots other labels: new ones by old ones; others stay."""
        self._lost_labels = {names.get(name, name) for name in self._lost_labels}
        for track in () if self.fork is None else self.fork.tracks:
            track.rename(names)

    def predict(self, seconds: float) -> None:
        """Predict the robots of the fork."""
        if self.fork is not None:
            self._table.filter.predict_with(self.fork.groups, seconds)

    def forget_old(self, stamp_ns: int) -> None:
        """Forget a fork that can no longer be right at an image."""
        if self.fork is not None and not self.fork.holds(stamp_ns):
            self.fork = None

    def explains(self, seen: Measurements, stamp_ns: int) -> bool:
        """Process an image that contradicts the robots; return whether the fork explains it.

        Args:
            seen: its boxes.
            stamp_ns: of the image, ns.
        """
        if self.fork is None:
            self.fork = self._forked(stamp_ns)
        threshold = self._matcher.threshold
        pairs = self._table.filter.compare(seen, threshold, 1.0, self.fork.groups)
        return self.fork.update(pairs, len(seen.index), threshold)

    def go_back(self) -> None:
        """Restore the fork, and keep a copy until nothing contradicts its robots."""
        if self.fork is not None:
            fork, self.fork = self.fork, self.fork.again()
            self._table.restore(fork)
            self._matcher.mismatch.end()
            self._lost_ns = None

    def update(self, rows: Indices, refused: int, stamp_ns: int, passed: float) -> None:
        """Update with whether robots explain an image; one or two are no evidence against a camera.

        Args:
            rows: that were updated.
            refused: number of labelled robots whose boxes were refused.
            stamp_ns: of the image, ns.
            passed: time since the last one, s.
        """
        tracks, joint = self._table.tracks, self._table.filter
        if not (self._matcher.mismatch.active or refused or self.fork) and self._lost_ns is None:
            return
        named = [tracks[row] for row in rows.tolist() if tracks[row].robot_id]
        lost = self._matcher.mismatch.active or (refused and refused >= len(named))
        if lost and self._lost_ns is None:
            self._lost_ns = stamp_ns
            self._lost_labels = {
                track.robot_id
                for track in tracks
                if stamp_ns - track.last_seen_ns < TRACK.recent_ns
            }
        if self.fork is not None:
            doubt = joint.ambiguity
            calm = self._lost_ns is None and not doubt.apart and not doubt.covariance.any()
            self.fork.calm_s = self.fork.calm_s + passed if calm else 0.0
        if self._lost_ns is None:
            return
        if lost or not named:
            joint.update_ambiguity(passed)
            return
        # A short displacement after which robots are reacquired shows in their velocities.
        soon = stamp_ns - self._lost_ns < TRACK.recent_ns
        old = sum(
            track.first_seen_ns < self._lost_ns or (soon and track.robot_id in self._lost_labels)
            for track in named
        )
        over = 2 * old > len(named)
        joint.update_ambiguity(0.0, over=over)
        if over:
            self._table.give_up_unverified()
        self._lost_ns = None

    def reject_unlabelled(self, stamp_ns: int) -> None:
        """Reject tracks that were only seen during the scene mismatch."""
        for track in self._table.tracks:
            if not track.robot_id and not track.label_pending and track.last_seen_ns < stamp_ns:
                track.rejected, track.rejection_cause = True, Cause.LOST_PLATFORM

    def regroup(self, ready: list[int]) -> set[int] | None:
        """Label tracks by their formation when all robots are displaced.

        Args:
            ready: rows of tracks with enough hits.

        Returns:
            The rows that they replace; None if the formation is ambiguous.
        """
        matched = self.regrouping.formation_match(ready, self._lost_labels)
        if matched is None:
            return None
        found, formation = matched
        joint = self._table.filter
        self._matcher.mismatch.end()
        joint.update_ambiguity(0.0, over=not formation.moved)
        if not formation.moved:
            self._table.give_up_unverified()
        if formation.moved and self.regrouping.at_home(found):
            joint.note_return()
            self._table.give_up_unverified()
        elif formation.moved:
            away = self.regrouping.displacement(found)
            joint.note_displacement(formation.turn, formation.spread, away)
        self._lost_ns = None
        return self.regrouping.relabel(found, formation.moved)

    def restore_labels(self, ready: list[int], boxes: int) -> None:
        """Restore robots at their old positions if boxes show them only there.

        Args:
            ready: rows of tracks with enough hits.
            boxes: number of boxes of the image.
        """
        tracks = self._table.tracks
        if any(track.robot_id and track.state is State.CONFIRMED for track in tracks):
            return
        if self.regrouping.are_back(ready, boxes, previous=True):
            self.regrouping.restore_labels()

    def _forked(self, stamp_ns: int) -> Fork:
        return Fork.of(stamp_ns, self._table.tracks, self._table.filter.groups)
