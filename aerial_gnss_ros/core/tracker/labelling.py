# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labelling: when tracks with enough hits get labels, also while a scene mismatch lasts.

Without a mismatch that is at once. During one, tracks may be displaced robots, which are
re-identified by their formation (`Regrouping`); unless robots are back where they were, other
tracks are only labelled once they have lasted.
"""

from __future__ import annotations

from aerial_gnss_ros.core.association.matcher import Matcher
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.tracker.box_account import BoxAccount
from aerial_gnss_ros.core.tracker.confirmation import TrackConfirmation
from aerial_gnss_ros.core.tracker.recovery import Recovery
from aerial_gnss_ros.core.tracker.track_table import TrackTable


class Labelling:
    """Labels tracks after each image.

    Args:
        table: the tracks.
        matcher: knows of a scene mismatch, which ends with a confirmed track.
        recovery: decides between the hypotheses of a mismatch.
        confirmation: confirms and labels.
        account: counts the pending boxes of labelled tracks.
    """

    def __init__(
        self,
        table: TrackTable,
        matcher: Matcher,
        recovery: Recovery,
        confirmation: TrackConfirmation,
        account: BoxAccount,
    ) -> None:
        self._table, self._matcher, self._recovery = table, matcher, recovery
        self._confirmation, self._account = confirmation, account

    def update(self, boxes: int, height: float, local: LocalMap, stamp_ns: int) -> set[int]:
        """Label the tracks with enough hits; return the rows of those that end.

        Those are tracks that continue in others, and rejected ones.

        Args:
            boxes: number of the image's boxes on the water.
            height: of the camera above the water, m.
            local: the map.
            stamp_ns: of the image, ns.
        """
        ready, gone = self._confirmation.ready(stamp_ns), set[int]()
        if ready or self._matcher.mismatch.active:
            gone |= self._confirm(ready, boxes, height, local, stamp_ns)
        for row, track in enumerate(self._table.tracks):
            if track.rejected and not track.robot_id and not track.previous_label:
                gone.add(row)
        return gone

    def _confirm(
        self, ready: list[int], boxes: int, height: float, local: LocalMap, stamp_ns: int
    ) -> set[int]:
        """Label tracks; return the rows that they replace (see `update`)."""
        mismatch = self._matcher.mismatch.active
        if mismatch:
            regrouped = self._recovery.regroup(ready)
            if regrouped is not None:
                self._account.confirm(self._table.tracks)
                return regrouped
        self._recovery.restore_labels(ready, boxes)
        back = not mismatch or self._recovery.regrouping.are_back(ready, boxes)
        if not back:
            ready = self._confirmation.ready(stamp_ns, lasting=True)
        if not ready:
            return set()
        if mismatch and back:
            self._table.give_up_unverified()
        if mismatch:
            self._matcher.mismatch.end()
        replaced = self._confirmation.confirm(ready, stamp_ns, height, local, back)
        self._account.confirm(self._table.tracks)
        return replaced
