# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The life of one track, and what it remembers for the time when its robot is out of sight."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.image_tracks import Labels
from aerial_gnss_ros.core.faults.noise_level import Innovation
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.rejection import Cause

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TrackTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    habit_s: float = 5.0
    """Velocities so far apart count as independent of one another. Judged."""
    strain_images: int = 8
    """Images over which a robot's normalised squared innovations are averaged. Judged."""


TUNING = TrackTuning()


@dataclass
class Track:
    """The life of one track; its numbers are those of the same row of `TrackTable.filter`.

    Attributes:
        class_id: class name as the detector gave it.
        first_seen_ns: stamp of the first image that showed it, ns.
        last_seen_ns: of the last one, ns.
        state: tentative, confirmed, coasting or lost.
        robot_id: its name, "" before it is confirmed.
        hits: stamps of the images that showed it, within `tracks.confirm_window_s`.
        innovation_ratio: fading mean of its squared innovations by their expectation; 1 is right.
        velocity: (2,) East, North when last seen, m/s.
        velocity_spread: (2, 2) covariance of that, m²/s².
        speed_history: sum of its squared velocities, mean of both axes, each `TUNING.habit_s`,
            m²/s².
        speed_history_count: how many independent ones.
        label_pending: whether it waits for its name, since it could be one of several robots.
        clutter_probability: probability that its boxes after the first are false ones, there by
            chance.
        rejected: whether a box was refused it, by which it would be faster than robots are, or it
            was only seen while telemetry was wrong.
        entered_view: whether its first box was at the edge of the picture: it came into view.
        pending_boxes: stamp (ns), u and v (px) of its boxes for as long as it has no name.
        near_misses: boxes just outside its gate that were no other's while it had no name.
        rejection_cause: of `rejected`, should it end without a name.
        innovations: of the last three images that showed it where it may be.
        previous_label: its name until all robots were elsewhere at once and another track went on
            under it; it has it again should they be back.
        unverified: whether it was confirmed while robots were not where they should be: its place
            is that of a camera that may have been wrong.
        labels: what the picture says of which robot it is, None where it says nothing.
        leaving_view: whether its last one is: should it vanish now, it has left the view, not
            dived.
    """

    class_id: str
    first_seen_ns: int
    last_seen_ns: int
    state: State = State.TENTATIVE
    robot_id: str = ""
    hits: deque[int] = field(default_factory=deque)
    innovation_ratio: float = 1.0
    velocity: Array = field(default_factory=lambda: np.zeros(2))
    velocity_spread: Array = field(default_factory=lambda: np.zeros((2, 2)))
    speed_history: float = 0.0
    speed_history_count: float = 0.0
    label_pending: bool = False
    clutter_probability: float = 1.0
    rejected: bool = False
    entered_view: bool = False
    leaving_view: bool = False
    pending_boxes: tuple[tuple[int, float, float], ...] = ()
    near_misses: int = 0
    rejection_cause: Cause = Cause.TOO_FAST
    innovations: tuple[Innovation, ...] = ()
    previous_label: str = ""
    unverified: bool = False
    labels: Labels | None = None

    def inherit_label(self, other: Track) -> None:
        """Go on under the name of a robot that this one turned out to be."""
        self.robot_id = other.robot_id
        self.speed_history, self.speed_history_count = (
            other.speed_history,
            other.speed_history_count,
        )

    def absorb(self, other: Track) -> None:
        """Take in a track without a name that turned out to be of the same robot."""
        if other.first_seen_ns < self.first_seen_ns:
            self.first_seen_ns, self.entered_view = other.first_seen_ns, other.entered_view
        self.hits = deque(sorted({*self.hits, *other.hits}))
        self.label_pending |= other.label_pending
        self.pending_boxes, other.pending_boxes = self.pending_boxes + other.pending_boxes, ()
        self.labels = self.labels or other.labels

    def swap_labels(self, other: Track) -> None:
        """Give each other's name: association had exchanged the two."""
        self.robot_id, other.robot_id = other.robot_id, self.robot_id
        self.speed_history, other.speed_history = other.speed_history, self.speed_history
        self.speed_history_count, other.speed_history_count = (
            other.speed_history_count,
            self.speed_history_count,
        )

    def typical_speed(self, speed: float) -> float:
        """Return one sigma of the velocity that it is used to, each axis, m/s.

        Args:
            speed: what is supposed of a robot of which nothing is known, m/s.
        """
        return float(np.sqrt((speed**2 + self.speed_history) / (1.0 + self.speed_history_count)))

    def coexisted(self, other: Track) -> bool:
        """Return whether one image showed both: then they are two robots."""
        return not set(self.hits).isdisjoint(other.hits)
