# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots as they were when telemetry or boxes began to contradict them.

That leaves two hypotheses: what comes is right since, or was right until then and is in error now.
The filter goes on with the first one. This keeps the second one: robots that nobody has seen since.
When a receiver jumps back to where it was, or boxes that the filter cannot explain fall image after
image where these robots should be, it was the second one, and what was seen meanwhile was seen
wrongly.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
    """After longer, robots that nobody saw can be anywhere, s. Judged."""
    calm_s: float = 1.0
    """The filter's own robots are right where nothing has contradicted them for so long, s.
    Judged."""
    agreeing_images: int = 3
    """So many images in a row must show robots where they should be. Judged."""
    recent_ns: int = 1_000_000_000
    """Robots that were seen within this time before are in view, ns. Judged."""
    robots_in_view: int = 2
    """At least so many robots must be in view: by itself one may be anything. Judged."""


TUNING = ForkTuning()


@dataclass
class Fork:
    """Robots at the image from which on they were contradicted, before any of its boxes counted.

    Attributes:
        stamp_ns: of that image.
        tracks: of the robots.
        groups: their joint laws, predicted to the present image.
        jumped: whether the drone's position had jumped.
        agreed: images in a row that show robots where these should be.
        calm_s: for how long nothing has contradicted the filter's own robots, s.
    """

    stamp_ns: int
    tracks: list[Track]
    groups: list[JointState]
    jumped: bool = False
    agreed: int = 0
    calm_s: float = 0.0

    @staticmethod
    def of(stamp_ns: int, tracks: list[Track], groups: list[JointState]) -> Fork:
        """Return it, with copies of all that changes."""
        return Fork(stamp_ns, copy.deepcopy(tracks), _copy(groups))

    def again(self) -> Fork:
        """Return a copy that can be gone back to, should robots be contradicted once more."""
        return Fork.of(self.stamp_ns, self.tracks, self.groups)

    def apart(self, rows: dict[str, int], mean: Array) -> dict[str, Array]:
        """Return how far robots are from where these should be, by name, (2,) m.

        Args:
            rows: by name.
            mean: (n, 2) places of all rows, m.
        """
        found = {}
        for group in self.groups:
            for slot, row in enumerate(group.rows.tolist()):
                name = self.tracks[row].robot_id
                if name in rows:
                    found[name] = mean[rows[name]] - group.robots[slot, :2]
        return found

    def holds(self, stamp_ns: int) -> bool:
        """Return whether it can still be gone back to at an image."""
        if self.calm_s > TUNING.calm_s and not self.jumped:
            return False
        return 0 <= stamp_ns - self.stamp_ns <= TUNING.longest_s * 1e9

    @property
    def unnamed(self) -> list[int]:
        """Rows of tracks that had no name."""
        return [row for row, track in enumerate(self.tracks) if not track.robot_id]

    def take(self, pairs: PairInnovations, boxes: int, threshold: float) -> bool:
        """Take in an image that the filter cannot explain; return whether this explains it.

        Args:
            pairs: how boxes lie to these robots.
            boxes: of the image.
            threshold: squared Mahalanobis distance at the edge of a gate.
        """
        seen = [
            row
            for row, one in enumerate(self.tracks)
            if one.robot_id
            and one.state is not State.TENTATIVE
            and not one.leaving_view
            and self.stamp_ns - one.last_seen_ns <= TUNING.recent_ns
        ]
        squared, _ = mahalanobis(pairs.offsets, pairs.spread)
        near = (squared <= threshold) & np.isin(pairs.rows, seen)
        rows, columns = set(pairs.rows[near].tolist()), set(pairs.columns[near].tolist())
        fits = min(len(rows), len(columns)) >= max(TUNING.robots_in_view, min(len(seen), boxes))
        self.agreed = self.agreed + 1 if fits else 0
        return self.agreed >= TUNING.agreeing_images


def _copy(groups: list[JointState]) -> list[JointState]:
    """Return copies that share nothing that changes but what no robots explained of the camera."""
    shared = [thing for one in groups for thing in (one.view, one.rotation_fault.ambiguity)]
    return copy.deepcopy(groups, {id(thing): thing for thing in shared})
