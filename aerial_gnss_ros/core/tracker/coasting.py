# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Coasting: how long tracks are predicted that no image shows, and when they are lost."""

from __future__ import annotations

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.tracker.confirmation import TrackConfirmation, transience
from aerial_gnss_ros.core.tracker.track_table import TrackTable
from aerial_gnss_ros.core.values.estimates import State


class Coasting:
    """Lets robots coast, and ends tracks that have not been seen for too long.

    Args:
        table: the tracks.
        confirmation: counts tracks that end without a label.
        config: how long robots coast.
    """

    def __init__(
        self, table: TrackTable, confirmation: TrackConfirmation, config: EstimatorConfig
    ) -> None:
        self._table, self._confirmation = table, confirmation
        self._coast_ns = round(config.tracks.coast_s * 1e9)
        self.reconfigure(config)

    def reconfigure(self, config: EstimatorConfig) -> None:
        """Use what another configuration states of classes from now on."""
        self._coast_of_class = {
            name: round(config.robot_class(name).coast_s * 1e9) for name, _ in config.classes
        }

    def coast_ns(self, class_id: str) -> int:
        """Return for how long robots of a class coast, ns."""
        return self._coast_of_class.get(class_id, self._coast_ns)

    def update(self, stamp_ns: int) -> set[int]:
        """Let all robots coast until an image shows them; return the rows of tracks that are lost.

        Args:
            stamp_ns: of the image, ns.
        """
        tracks, window_ns = self._table.tracks, self._confirmation.rule.window_ns
        came_ns = stamp_ns
        for track in tracks:  # robots stay until pending labels are decided
            if track.label_pending:
                came_ns = min(came_ns, track.first_seen_ns)
        asked_ns: dict[str, int] = {}  # and until tracks that may be they are old
        for track in tracks:
            age_ns = stamp_ns - track.first_seen_ns
            if track.may_be and age_ns <= self.coast_ns(track.class_id):
                for label in track.may_be:
                    asked_ns[label] = min(asked_ns.get(label, stamp_ns), track.first_seen_ns)
        lost, tentative, coasting = set[int](), State.TENTATIVE, State.COASTING
        new = sum(track.state is tentative for track in tracks)
        for row, track in enumerate(tracks):
            unseen_ns, patience_ns = stamp_ns - track.last_seen_ns, window_ns
            if track.state is not tentative:
                track.state = coasting
                patience_ns = self.coast_ns(track.class_id)
                unseen_ns = min(came_ns, asked_ns.get(track.robot_id, came_ns)) - track.last_seen_ns
            if unseen_ns > patience_ns:
                if track.state is tentative and not self._confirmation.robots_missing(stamp_ns):
                    self._confirmation.transients.note(stamp_ns, transience(track, new))
                track.state = State.LOST
                lost.add(row)
        return lost
