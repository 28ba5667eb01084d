# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A second hypothesis: the robots as they were before telemetry or boxes contradicted them.

Either the new data are right, or the old ones were. The filter continues with the new data; the
fork keeps the robots of the old hypothesis, predicted without updates. When a receiver jumps back,
or boxes that the filter cannot explain fall where the fork's robots are expected in several images,
the old hypothesis was right, and what was seen meanwhile had a wrong pose.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.track import TUNING as TRACK
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.filter.innovation import PairInnovations
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis
from aerial_gnss_ros.core.values.estimates import State

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ForkTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    longest_s: float = 60.0
    """Greatest age of a fork: after that its robots can be anywhere, s. Judged."""
    calm_s: float = 1.0
    """Time without contradictions after which the filter's own robots are accepted, s. Judged."""
    agreeing_images: int = 3
    """Consecutive images that must agree with the fork. Judged."""
    robots_in_view: int = 2
    """Least number of robots in view: a single one may match by chance. Judged."""


TUNING = ForkTuning()


@dataclass
class Fork:
    """The robots at the first contradicting image, before any of its boxes was used.

    Attributes:
        stamp_ns: of that image.
        tracks: copies of the tracks.
        groups: their joint states, predicted to the present image.
        agreed: consecutive images that agree with the fork.
        calm_s: time for which nothing has contradicted the filter's own robots, s.
    """

    stamp_ns: int
    tracks: list[Track]
    groups: list[JointState]
    agreed: int = 0
    calm_s: float = 0.0

    @staticmethod
    def of(stamp_ns: int, tracks: list[Track], groups: list[JointState]) -> Fork:
        """Return a fork with copies of everything that changes."""
        return Fork(stamp_ns, copy.deepcopy(tracks), _copy(groups))

    def again(self) -> Fork:
        """Return a copy, for another contradiction."""
        return Fork.of(self.stamp_ns, self.tracks, self.groups)

    def apart(self, rows: dict[str, int], mean: Array) -> dict[str, Array]:
        """Return the offsets (2,) of robots from those of the fork, by label, m.

        Args:
            rows: by label.
            mean: (n, 2) positions of all rows, m.
        """
        found = {}
        for group in self.groups:
            for slot, row in enumerate(group.rows.tolist()):
                name = self.tracks[row].robot_id
                if name in rows:
                    found[name] = mean[rows[name]] - group.robots[slot, :2]
        return found

    def holds(self, stamp_ns: int) -> bool:
        """Return whether the fork may still be right at an image."""
        if self.calm_s > TUNING.calm_s:
            return False
        return 0 <= stamp_ns - self.stamp_ns <= TUNING.longest_s * 1e9

    @property
    def unnamed(self) -> list[int]:
        """Rows of tracks without a label."""
        return [row for row, track in enumerate(self.tracks) if not track.robot_id]

    def update(self, pairs: PairInnovations, boxes: int, threshold: float) -> bool:
        """Update with an image that the filter cannot explain; return whether the fork explains it.

        Args:
            pairs: innovations of these robots.
            boxes: number of boxes of the image.
            threshold: squared Mahalanobis distance at the edge of a gate.
        """
        seen = [
            row
            for row, one in enumerate(self.tracks)
            if one.robot_id
            and one.state is not State.TENTATIVE
            and not one.leaving_view
            and self.stamp_ns - one.last_seen_ns <= TRACK.recent_ns
        ]
        squared, _ = mahalanobis(pairs.offsets, pairs.spread)
        near = (squared <= threshold) & np.isin(pairs.rows, seen)
        rows, columns = set(pairs.rows[near].tolist()), set(pairs.columns[near].tolist())
        fits = min(len(rows), len(columns)) >= max(TUNING.robots_in_view, min(len(seen), boxes))
        self.agreed = self.agreed + 1 if fits else 0
        return self.agreed >= TUNING.agreeing_images


def _copy(groups: list[JointState]) -> list[JointState]:
    """Return a copy that shares only the attitude ambiguity and the camera view."""
    shared = [thing for one in groups for thing in (one.view, one.rotation_fault.ambiguity)]
    return copy.deepcopy(groups, {id(thing): thing for thing in shared})
