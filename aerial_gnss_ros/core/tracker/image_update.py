# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Update of the tracks with the boxes of one image: association, correction, and new tracks."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.decision import NO_PAIRS
from aerial_gnss_ros.core.association.matcher import Matcher
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.identity.encounters import Encounters
from aerial_gnss_ros.core.tracker.confirmation_rule import ConfirmationRule
from aerial_gnss_ros.core.tracker.image_evidence import TUNING as IMAGE_EVIDENCE
from aerial_gnss_ros.core.tracker.image_evidence import ImageEvidence
from aerial_gnss_ros.core.tracker.recovery import Recovery
from aerial_gnss_ros.core.tracker.track_table import TrackTable
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Assigned(NamedTuple):
    """Measurements that are assigned to tracks.

    Attributes:
        rows: (k,) of the tracks.
        columns: (k,) of their measurements.
        image_cost: minus twice the log likelihood (n, m) of n tracks' m measurements by tracking in
            the image, None where nothing is in doubt.
    """

    rows: Indices
    columns: Indices
    image_cost: Array | None = None


class ImageUpdate:
    """Associates boxes with tracks, and corrects these.

    Args:
        table: the tracks.
        matcher: assigns boxes to tracks.
        encounters: finds exchanged labels of robots that have met.
        evidence: of labels, from tracking in the image.
        recovery: is told whether robots explain the image.
        rule: of confirmation; hits count for the length of its window.
    """

    def __init__(
        self,
        table: TrackTable,
        matcher: Matcher,
        encounters: Encounters,
        evidence: ImageEvidence,
        recovery: Recovery,
        rule: ConfirmationRule,
    ) -> None:
        self._table, self._matcher, self._encounters = table, matcher, encounters
        self._evidence, self._recovery, self._rule = evidence, recovery, rule

    def assign(self, seen: Measurements, boxes: DetectionFrame) -> Assigned:
        """Assign measurements to tracks.

        Args:
            seen: the image's measurements.
            boxes: all of the image.
        """
        tracks, stamp_ns = self._table.tracks, boxes.stamp_ns
        image_cost = cache(lambda: self._evidence.cost(tracks, boxes, seen))
        self._matcher.fresh_s = self._rule.window_ns * 1e-9
        able = self._matcher.gate(tracks, seen, stamp_ns, image_cost)
        if able is None:
            return Assigned(*NO_PAIRS)
        self._table.note_innovations(able, seen, stamp_ns)
        decided = self._matcher.assign(tracks, able, len(seen.index), stamp_ns)
        self._table.apply(decided, able)
        rows, columns = decided.rows, decided.columns
        if not (able.doubtful or self._evidence.blind):
            return Assigned(rows, columns)
        # While poses are uncertain or wrong, one robot's box may lie in another robot's gate.
        kept = image_cost()[rows, columns] < IMAGE_EVIDENCE.excluded_cost
        return Assigned(rows[kept], columns[kept], image_cost())

    def correct(
        self,
        seen: Measurements,
        boxes: DetectionFrame,
        assigned: Assigned,
        passed: float,
    ) -> tuple[dict[int, int], Indices]:
        """Correct tracks by assigned measurements, and start tracks from the others.

        Args:
            seen: the image's measurements.
            boxes: all of the image.
            assigned: measurements to tracks.
            passed: time since the last image, s.

        Returns:
            Boxes by row of the track that they measured or started; and those that are refused, as
            they imply an impossible speed.
        """
        tracks, stamp_ns = self._table.tracks, boxes.stamp_ns
        rows, columns, cost = assigned
        columns, swaps = self._encounters.update(tracks, rows, columns, seen, stamp_ns, cost)
        for one, other in swaps:
            tracks[one].swap_labels(tracks[other])
        window_ns = self._rule.window_ns
        impossible, labelled = self._table.update(seen, rows, columns, stamp_ns, window_ns)
        fast = np.isin(rows, impossible)
        self._recovery.update(rows[~fast], labelled, stamp_ns, passed)
        used = columns[~fast]
        measured = dict(zip(rows[~fast].tolist(), seen.index[used].tolist(), strict=True))
        if len(columns) < len(seen.index):
            self._table.start(seen, measured, np.concatenate([used, columns[fast]]), boxes)
        return measured, seen.index[columns[fast]]
