# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Account of boxes: each one is used or refused exactly once.

A box that updates a labelled robot is used. One that starts or updates a tentative track is
pending: it is used when the track is confirmed, and refused as `unconfirmed` when it ends before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.georeferencing.size_fit import SizeFit
from aerial_gnss_ros.core.identity.labels import Box
from aerial_gnss_ros.core.tracker.score_evidence import log_odds
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.rejection import Cause, Reason, Rejection

Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class BoxAccountTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    most_pending: int = 1000
    """Greatest number of pending boxes of a track; the oldest are refused. Judged."""
    least_refused: int = 20
    """Least number of refused boxes at which a complaint is made. Judged."""


TUNING = BoxAccountTuning()


@dataclass(frozen=True)
class Settled:
    """Boxes decided since the last call, of the last image and earlier ones.

    Attributes:
        used: number of boxes that updated robots.
        refused: those whose track ended unconfirmed, each with the stamp of its own image.
    """

    used: int = 0
    refused: tuple[Rejection, ...] = ()


class BoxAccount:
    """Collects decisions until they are asked for.

    Args:
        doubt: why a track's boxes are not like a robot's; None: they are.
    """

    def __init__(self, doubt: Callable[[Track], Cause | None] = lambda _: None) -> None:
        self._doubt = doubt
        self._used = 0
        self._refused: list[Rejection] = []

    def drain(self) -> Settled:
        """Return the decisions since the last call."""
        settled = Settled(self._used, tuple(self._refused))
        self._used, self._refused = 0, []
        return settled

    def note(
        self,
        tracks: list[Track],
        measured: dict[int, int],
        boxes: DetectionFrame,
        sizes: SizeFit | None = None,
    ) -> None:
        """Record which boxes of an image updated or started tracks, labelled or not.

        Args:
            tracks: by row.
            measured: boxes by row.
            boxes: of the image.
            sizes: of these boxes, where a length is stated for a class.
        """
        centers, scores = boxes.centers.tolist(), boxes.scores.tolist()
        for row, index in measured.items():
            track = tracks[row]
            if track.robot_id:
                self._used += 1
                continue
            track.score_sum, track.odds_sum, track.score_count = (
                track.score_sum + scores[index],
                track.odds_sum + log_odds(scores[index]),
                track.score_count + 1,
            )
            if sizes is not None:
                track.sizes += sizes.of(index)
            u, v = centers[index]
            track.pending_boxes = (*track.pending_boxes, (boxes.stamp_ns, u, v))
            if len(track.pending_boxes) > TUNING.most_pending:
                self._refuse(track.pending_boxes[:1], self._clutter(track))
                track.pending_boxes = track.pending_boxes[1:]

    @staticmethod
    def keep_pending(tracks: Iterable[Track], boxes: set[Box]) -> set[Box]:
        """Forget all pending boxes but some, and return which of these are pending.

        Args:
            tracks: of the boxes.
            boxes: those that nobody else has decided on.
        """
        kept: set[Box] = set()
        for track in tracks:
            track.pending_boxes = tuple(one for one in track.pending_boxes if one in boxes)
            kept.update(track.pending_boxes)
        return kept

    def confirm(self, tracks: Iterable[Track]) -> None:
        """Count the pending boxes of labelled tracks as used."""
        for track in tracks:
            if track.robot_id and track.pending_boxes:
                self._used += len(track.pending_boxes)
                track.pending_boxes = ()

    def end(
        self, tracks: Iterable[Track], hits: int = 0, images: int = 0, confused: bool = False
    ) -> None:
        """Refuse the pending boxes of tracks that end.

        Args:
            tracks: that end.
            hits: measurements that would have confirmed them; 0: they end for another reason.
            images: number of images within the confirmation window.
            confused: whether a scene mismatch has lost most robots.
        """
        for track in tracks:
            if track.pending_boxes:
                self._refuse(track.pending_boxes, self._cause(track, hits, images, confused))
                track.pending_boxes = ()

    def _refuse(self, boxes: tuple[Box, ...], cause: Cause) -> None:
        self._refused += [Rejection(t, Reason.UNCONFIRMED, u, v, cause) for t, u, v in boxes]

    def _cause(self, track: Track, hits: int, images: int, confused: bool) -> Cause:
        """Return the likeliest cause why a track was not confirmed."""
        if track.rejected:
            return track.rejection_cause
        if not hits:
            return self._doubt(track) or Cause.CUT_SHORT
        if len(track.hits) >= hits:
            return Cause.LOST_PLATFORM if confused else self._clutter(track)
        if images < hits:
            return Cause.IMAGES_TOO_SELDOM
        return Cause.OUT_OF_GATE if track.near_misses else Cause.TOO_FEW_IMAGES

    def _clutter(self, track: Track) -> Cause:
        return self._doubt(track) or Cause.CLUTTER


def box_masks(
    seen: Measurements, measured: dict[int, int], refused: Indices, boxes: int
) -> tuple[Mask, Mask]:
    """Return which boxes (n,) of an image have no track, and which were refused theirs.

    Args:
        seen: the image's measurements.
        measured: boxes by row of the track that they updated or started.
        refused: boxes that imply an impossible speed.
        boxes: n.
    """
    gated, too_fast = np.zeros(boxes, np.bool_), np.zeros(boxes, np.bool_)
    if len(measured) == len(seen.index) and not len(refused):
        return gated, too_fast
    gated[seen.index] = True
    gated[list(measured.values())] = False
    gated[refused] = False
    too_fast[refused] = True
    return gated, too_fast


def complaint(
    used: int,
    refused: Mapping[Reason, int],
    causes: Mapping[Cause, int],
    least: int = TUNING.least_refused,
) -> str:
    """Return why most boxes are refused, as a sentence; empty if most are used.

    Args:
        used: number of boxes that updated robots.
        refused: number of others, by reason.
        causes: the `unconfirmed` among them by cause.
        least: least number of boxes for a complaint.
    """
    total = sum(refused.values())
    if total < max(least, used):
        return ""
    reason = max(refused, key=lambda one: (refused[one], one))
    words = f"{total} of {used + total} boxes updated no robot, {refused[reason]} as {reason}"
    if reason is not Reason.UNCONFIRMED or not causes:
        return f"{words}: {reason.meaning}"
    cause = max(causes, key=lambda one: (causes[one], one))
    return f"{words}, mostly {cause}: {cause.meaning}"
