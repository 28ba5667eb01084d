# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that vanished in view so soon that they were more likely foam or glint.

A track is confirmed while few transients are expected to last as long and to score as high
(`transients`). If it then vanishes where the camera looks, that is evidence, too: a robot dives
about once in the time for which it may coast, foam dissolves within its lifetime. Where foam is the
likelier, the robot keeps its label and its track, but is not published until an image shows it
again: a position of foam that drifts for minutes helps nobody.
"""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.tracker.coasting import Coasting
from aerial_gnss_ros.core.tracker.confirmation import TrackConfirmation
from aerial_gnss_ros.core.tracker.track_table import TrackTable
from aerial_gnss_ros.core.tracker.transients import TUNING as TRANSIENTS
from aerial_gnss_ros.core.values.estimates import State


class VanishedRobots:
    """Marks robots that vanished (`Track.vanished`).

    Args:
        table: the tracks.
        confirmation: knows transients, and how soon images follow one another.
        coasting: knows for how long robots may coast.
    """

    def __init__(
        self, table: TrackTable, confirmation: TrackConfirmation, coasting: Coasting
    ) -> None:
        self._table, self._confirmation, self._coasting = table, confirmation, coasting

    def update(self, camera: CameraModel, stamp_ns: int, passed_s: float) -> None:
        """Update with an image that robots agree with.

        Args:
            camera: lens and image.
            stamp_ns: of the image, ns.
            passed_s: time since the last one, s.
        """
        unseen: list[int] = []
        for row, track in enumerate(self._table.tracks):
            if track.state is not State.COASTING:
                track.unseen_in_view_s, track.vanished = 0.0, False
            elif not (track.vanished or track.leaving_view) and self._is_brief(track, stamp_ns):
                unseen.append(row)
        if not unseen or self._confirmation.robots_missing(stamp_ns):
            return
        joint, rule = self._table.filter, self._confirmation.rule
        places = joint.moments()[0][unseen, :2]
        predicted = linearise(joint.trajectory.seen_from, joint.platform[0], places)
        expected = predicted.seen & camera.inside(predicted.pixels)
        for row in np.array(unseen)[expected].tolist():
            track = self._table.tracks[row]
            track.unseen_in_view_s += min(passed_s, rule.interval_s)
            track.vanished = track.unseen_in_view_s > rule.window_ns * 1e-9

    def _is_brief(self, track: Track, stamp_ns: int) -> bool:
        """Return whether foam that lasted and scored like a track is likelier than a robot."""
        transients = self._confirmation.transients
        foam = transients.expected(stamp_ns, 0.0, track.known_s, track.mean_score)
        rarer = self._coasting.coast_ns(track.class_id) * 1e-9 / TRANSIENTS.lifetime_s
        return foam * rarer > 1.0  # a robot dives more rarely than foam dissolves
