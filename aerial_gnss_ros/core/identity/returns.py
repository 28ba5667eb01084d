# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""New tracks that may be robots that were out of view, and what is decided about them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.track import EarlierLabel, Track
from aerial_gnss_ros.core.identity.return_position import VelocityLikelihood
from aerial_gnss_ros.core.identity.return_rules import TUNING as RULES

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ReturnCandidates:
    """New tracks, and the robots that they may be.

    Attributes:
        tracks: all of them.
        away: n rows of robots that may have been out of view.
        ready: m rows of new tracks.
        between: offsets (n, m, 2) from robots to new tracks, m, and covariances (n, m, 2, 2) as the
            filter has them, m².
        velocities: velocity likelihoods of the new tracks.
        stamp_ns: of the image, ns.
        height: of the camera above the water, m.
        newcomers: expected number of new robots while robots may be out of view.
    """

    tracks: list[Track]
    away: list[int]
    ready: list[int]
    between: tuple[Array, Array]
    velocities: VelocityLikelihood
    stamp_ns: int
    height: float
    newcomers: float

    @property
    def robots(self) -> list[Track]:
        """The n robots that may have been out of view."""
        return [self.tracks[row] for row in self.away]

    @property
    def unseen_s(self) -> Array:
        """For how long the robots have been out of view (n,), s."""
        return np.array([(self.stamp_ns - one.last_seen_ns) * 1e-9 for one in self.robots])


@dataclass
class Returns:
    """Decisions about new tracks and robots that were out of view.

    Attributes:
        robots: by row of a track, the row of the robot that it is. It is a new track, or one that
            had got a new label.
        waiting: rows of new tracks whose decision is deferred.
        ended: rows of robots that surfaced but cannot be evidence apart.
        label_probabilities: by row of a robot that surfaced, the probability of each new row to be
            that robot.
        other: by a new row and that of a robot out of view, the probability that they are the same.
        unknown: by new row, the probability that it is a new robot.
        may_be: by row of a new track, the robots out of view that it may be if it gets a new label.
    """

    robots: dict[int, int] = field(default_factory=dict)
    waiting: set[int] = field(default_factory=set)
    ended: set[int] = field(default_factory=set)
    label_probabilities: dict[int, dict[int, float]] = field(default_factory=dict)
    other: dict[tuple[int, int], float] = field(default_factory=dict)
    unknown: dict[int, float] = field(default_factory=dict)
    may_be: dict[int, dict[str, EarlierLabel]] = field(default_factory=dict)


def decided(new: list[int], old: list[int], probabilities: Array, waiting: set[int]) -> Returns:
    """Return the labels of new tracks by their probabilities, (k, k) robots by tracks."""
    done = Returns(waiting=waiting)
    for k, law in enumerate(probabilities.tolist()):
        done.label_probabilities[old[k]] = dict(zip(new, law, strict=True))
        if law[k] > RULES.naming_probability:
            done.robots[new[k]] = old[k]
        else:
            done.ended.add(old[k])
    return done
