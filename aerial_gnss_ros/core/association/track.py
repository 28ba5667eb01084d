# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A track: its state, and what re-identification needs while its robot is out of view."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.image_labels import LabelEvidence
from aerial_gnss_ros.core.faults.noise_level import NO_INNOVATIONS, Innovations
from aerial_gnss_ros.core.georeferencing.size_fit import NO_SIZES, SizeSums
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.rejection import Cause

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TrackTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    habit_s: float = 5.0
    """Time between velocities that count as independent, s. Judged."""
    recent_ns: int = 1_000_000_000
    """A robot seen within this time is in view, and a fault that is over sooner was short, ns.
    Judged."""


TUNING = TrackTuning()


class EarlierLabel(NamedTuple):
    """What was known, when a track got a new label, of one that its robot may have had before.

    Attributes:
        place: minus twice the log likelihood ratio of position and velocity.
        odds: likelihood ratio of the absence.
        ratio: likelihood ratio of both to a new robot, with doubt.
        absence_s: how long the robot was submerged, s; NaN: it was not.
    """

    place: float
    odds: float
    ratio: float
    absence_s: float


@dataclass
class Track:
    """One track; its state vector is in the same row of `TrackTable.filter`.

    What an attribute holds is never changed in place, but replaced: snapshots and copies share it.

    Attributes:
        class_id: class name as the detector gave it.
        first_seen_ns: stamp of the first image that showed it, ns.
        last_seen_ns: of the last one, ns.
        state: tentative, confirmed, coasting or lost.
        robot_id: its label, "" before confirmation.
        hits: stamps of the images that showed it, within `tracks.confirm_window_s`.
        velocity: (2,) East, North when last seen, m/s.
        velocity_spread: (2, 2) its covariance, m²/s².
        speed_history: sum of squared velocities, mean of both axes, each `TUNING.habit_s`, m²/s².
        speed_history_count: number of independent ones.
        label_pending: whether its label is deferred, as it could be one of several robots.
        clutter_probability: probability that its boxes after the first are clutter.
        rejected: whether a box was refused because it implied an impossible speed, or it was only
            seen while telemetry was wrong.
        entered_view: whether its first box was at the edge of the image: it entered the view.
        pending_boxes: stamp (ns), u and v (px) of its boxes while it has no label.
        near_misses: unassociated boxes near its gate while it has no label.
        inherited_ns: stamp of the first box of the robot whose label it has inherited, ns; 0: none.
        score_sum: sum of the scores of its boxes while it has no label.
        odds_sum: sum of the log odds of these scores.
        score_count: number of these boxes.
        sizes: sums over the sizes of these boxes, where a length is stated for its class.
        rejection_cause: cause of `rejected`, if it ends without a label.
        innovations: of the last three images with a box near its gate, see
            `NoiseLevel.update`.
        previous_label: its label before all robots were displaced together and another track
            inherited it; restored if they return.
        unverified: whether it was confirmed during a scene mismatch, so that its position may come
            from a wrong pose.
        label_evidence: evidence of its label from tracking in the image, None without.
        may_be: labels of robots out of view that it may be, while it has a new one instead.
        leaving_view: whether its last box was at the edge of the image: if it vanishes, it has left
            the view, not dived.
        unseen_in_view_s: time for which images that should show it have not, s, if it was seen
            briefly.
        vanished: whether it then was more likely foam than a robot (`VanishedRobots`).
    """

    class_id: str
    first_seen_ns: int
    last_seen_ns: int
    state: State = State.TENTATIVE
    robot_id: str = ""
    hits: tuple[int, ...] = ()
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
    inherited_ns: int = 0
    score_sum: float = 0.0
    odds_sum: float = 0.0
    score_count: int = 0
    sizes: SizeSums = NO_SIZES
    rejection_cause: Cause = Cause.TOO_FAST
    innovations: Innovations = NO_INNOVATIONS
    previous_label: str = ""
    unverified: bool = False
    label_evidence: LabelEvidence | None = None
    may_be: Mapping[str, EarlierLabel] = field(default_factory=dict)
    unseen_in_view_s: float = 0.0
    vanished: bool = False

    def inherit_label(self, other: Track) -> None:
        """Take over the label of the robot that this track continues."""
        self.robot_id, self.inherited_ns = other.robot_id, other.since_ns
        self.may_be = other.may_be
        self.speed_history, self.speed_history_count = (
            other.speed_history,
            other.speed_history_count,
        )

    def absorb(self, other: Track) -> None:
        """Merge an unlabelled duplicate track into this one."""
        if other.first_seen_ns < self.first_seen_ns:
            self.first_seen_ns, self.entered_view = other.first_seen_ns, other.entered_view
        self.hits = tuple(sorted({*self.hits, *other.hits}))
        self.score_sum, self.odds_sum, self.score_count = (
            self.score_sum + other.score_sum,
            self.odds_sum + other.odds_sum,
            self.score_count + other.score_count,
        )
        self.sizes += other.sizes
        self.label_pending |= other.label_pending
        self.pending_boxes, other.pending_boxes = self.pending_boxes + other.pending_boxes, ()
        self.label_evidence = self.label_evidence or other.label_evidence

    def rename(self, names: Mapping[str, str]) -> None:
        """Give robots other labels: new ones by old ones; others stay."""
        self.robot_id = names.get(self.robot_id, self.robot_id)
        self.previous_label = names.get(self.previous_label, self.previous_label)
        self.may_be = {names.get(name, name): one for name, one in self.may_be.items()}
        if self.label_evidence is not None:
            self.label_evidence = self.label_evidence.renamed(names)

    @property
    def since_ns(self) -> int:
        """Return the stamp of the first box of its robot, ns."""
        return self.inherited_ns or self.first_seen_ns

    @property
    def known_s(self) -> float:
        """Time from the first box of its robot to its last one, s."""
        return (self.last_seen_ns - self.since_ns) * 1e-9

    @property
    def mean_score(self) -> float:
        """Mean score of its boxes while it has no label; 1 without any."""
        return self.score_sum / self.score_count if self.score_count else 1.0

    @property
    def lasted_s(self) -> float:
        """Time from its first box to its last one, s."""
        return (self.last_seen_ns - self.first_seen_ns) * 1e-9

    def swap_labels(self, other: Track) -> None:
        """Exchange the labels of two tracks that association had exchanged."""
        self.robot_id, other.robot_id = other.robot_id, self.robot_id
        self.may_be, other.may_be = other.may_be, self.may_be
        self.speed_history, other.speed_history = other.speed_history, self.speed_history
        self.speed_history_count, other.speed_history_count = (
            other.speed_history_count,
            self.speed_history_count,
        )

    def typical_speed(self, speed: float) -> float:
        """Return one sigma of its velocity so far, each axis, m/s.

        Args:
            speed: prior sigma of an unknown velocity, m/s.
        """
        return float(np.sqrt((speed**2 + self.speed_history) / (1.0 + self.speed_history_count)))

    def coexisted(self, other: Track) -> bool:
        """Return whether an image showed both, so that they are two robots."""
        return not set(self.hits).isdisjoint(other.hits)
