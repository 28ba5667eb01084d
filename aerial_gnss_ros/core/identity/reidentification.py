# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which robot out of sight has come up again, or whether a new one has.

Inside a coasting robot's gate something new is confirmed. The longer a robot was away, the wider is
its gate, and the likelier is what comes up there another robot. So the likelihoods are compared:
that the robot is there, and that one is which nobody has seen yet; of these one comes up now and
then, so that a robot back after seconds competes with fewer than one back after minutes. Where a
robot out of sight can be, and how it swims there, is a mixture (`return_position`). Besides, robots
come up after about as long as others did (`return_time`).

Where two robots out of sight could be the new track, nothing is decided for a while: if the
other one comes up as well, the two are told apart by how they lie to one another, whatever error
they share. That there are two must be seen in one image: a robot whose track lost a box or two has
grown a second track, and is still one robot. Where that leaves open which is which, both get new
names, and the old ones end: nothing that the two show later tells them apart. If the other one does
not come up, and neither is likely enough, the new track gets a new name, and those out of sight
keep theirs.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.assignment import TUNING as ASSIGNMENT
from aerial_gnss_ros.core.association.assignment import cheapest
from aerial_gnss_ros.core.association.image_tracks import UNTOLD
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.identity.return_permutation import likeliest_permutation
from aerial_gnss_ros.core.identity.return_position import ReturnPosition, VelocityLikelihood
from aerial_gnss_ros.core.identity.return_time import AbsenceTimes
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class ReidentificationTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    view_heights: float = 2.0
    """Side of the water in view, as a multiple of the height. Judged."""
    doubt_m: float = 0.5
    """Both allow for a place that is wrong by so much more than the filter says, one sigma, m.
    Judged."""
    patience_s: float = 4.0
    """How long a track waits for the other robot to come up, too, s; those that come up one after
    the other wait for the last of them. Judged."""
    patience_share: float = 0.05
    """It waits longer by this share of the time for which the nearest robot was out of sight.
    Judged."""
    look_s: float = 1.0
    """How long a track in doubt waits to show how it swims, s. Judged."""
    naming_probability: float = 0.8
    """Probability from which a new track gets a robot's name, against all other robots and those
    that nobody has seen. Below, it gets a new one: a name on the wrong robot is a confident wrong
    position, which is much worse. docs/results/identity.md has what other values give."""
    unsure_probability: float = 0.05
    """Probability from which it is remembered that a track may be another robot than it is named.
    Judged."""


TUNING = ReidentificationTuning()


@dataclass
class Returns:
    """Who came up.

    Attributes:
        found: by row of a new track, the row of the robot that it is.
        waiting: rows of new tracks that wait for more.
        ended: rows of robots that came up, but nobody can tell which they are.
        label_probabilities: by row of a robot that came up, the probability of each new row to be
            that robot.
        other: by a new row and that of a robot out of sight, the probability that it is that one.
        unknown: by new row, the probability that it is a robot that nobody has seen before.
    """

    found: dict[int, int] = field(default_factory=dict)
    waiting: set[int] = field(default_factory=set)
    ended: set[int] = field(default_factory=set)
    label_probabilities: dict[int, dict[int, float]] = field(default_factory=dict)
    other: dict[tuple[int, int], float] = field(default_factory=dict)
    unknown: dict[int, float] = field(default_factory=dict)


class Reidentification:
    """Compares newly confirmed tracks with robots out of sight.

    Args:
        motion: of robots out of sight, as the filter has it.
        threshold: squared Mahalanobis distance at the edge of a gate.
        coast_s: for how long a robot may be out of sight, s.
    """

    def __init__(self, motion: MotionModel, threshold: float, coast_s: float) -> None:
        self._whereabouts = ReturnPosition(motion)
        self._threshold = threshold
        self._absences = AbsenceTimes(coast_s)

    def reset(self) -> None:
        """Forget how long robots were away."""
        self._absences.reset()

    def decide(
        self,
        tracks: list[Track],
        away: list[int],
        ready: list[int],
        between: tuple[Array, Array],
        swims: VelocityLikelihood,
        stamp_ns: int,
        height: float,
        newcomers: float,
    ) -> Returns:
        """Return which new tracks are which robots.

        Args:
            tracks: all of them.
            away: n rows of robots that may have been out of sight.
            ready: m rows of new tracks.
            between: offsets (n, m, 2) from robots to new tracks, m, and covariances (n, m, 2, 2)
                as the filter has them, m².
            swims: how the new tracks swim.
            stamp_ns: of the image, ns.
            height: of the camera above the water, m.
            newcomers: robots never seen that are expected to come up in the picture in `coast_s`.
        """
        squared, _ = mahalanobis(*between)
        possible = (squared <= self._threshold) & np.array(
            [[_can_be(tracks[old], tracks[new]) for new in ready] for old in away], dtype=bool
        )
        unseen = np.array([(stamp_ns - tracks[row].last_seen_ns) * 1e-9 for row in away])
        gone = np.array([[_absence(tracks[old], tracks[new]) for new in ready] for old in away])
        odds = self._absences.odds(gone)
        density, vague = self._densities(tracks, away, unseen, between, swims)
        share = self._absences.share(gone, unseen)
        known, side = [tracks[row] for row in away], TUNING.view_heights * max(height, 1.0)
        fresh = self._whereabouts.new_robot_density(known, between[0], side, swims)
        labelled, other = _labels(known, [tracks[row] for row in ready])
        density, vague = density * labelled, vague * labelled
        each = newcomers * share * fresh * other
        each = np.maximum(each, 1e-12)
        place = -2.0 * np.log(np.maximum(density, 1e-300) / each)
        rows, columns = cheapest(place - 2.0 * np.log(odds), possible, np.zeros(len(away)))
        vague = np.where(possible, odds * vague, 0.0)
        # Where as many have come up as could be meant, their lie to one another decides.
        settled = (possible.any(axis=1).sum() <= len(columns)) and len(columns) > 1
        came = [tracks[ready[column]] for column in columns]
        settled &= all(a.coexisted(b) for a, b in combinations(came, 2))
        likely = vague / (vague.sum(axis=0) + each)
        age = np.array([(stamp_ns - tracks[row].first_seen_ns) * 1e-9 for row in ready])
        if settled:
            _, chances = likeliest_permutation(place, possible, rows, columns, gone, self._absences)
            waits = np.zeros(len(ready), dtype=bool)
            waits[columns] = chances.diagonal() < 1.0 - TUNING.unsure_probability
            waits &= age[columns].min() < TUNING.look_s
        else:
            nearest = unseen[np.where(possible, squared, np.inf).argmin(axis=0)]
            unclear, best = _waits(vague), likely.max(axis=0)
            waits = (
                (best > TUNING.unsure_probability)
                & (best < 1.0 - TUNING.unsure_probability)
                & (age < TUNING.look_s)
            )
            waits |= unclear & (
                age[unclear].min(initial=np.inf)
                < TUNING.patience_s + TUNING.patience_share * nearest
            )
        waiting = {row for row, one in zip(ready, waits, strict=True) if one}
        sure = [
            k
            for k, (i, j) in enumerate(zip(rows, columns, strict=True))
            if ready[j] not in waiting and (settled or likely[i, j] > TUNING.naming_probability)
        ]
        rows, columns = rows[sure], columns[sure]
        rows, chances = likeliest_permutation(place, possible, rows, columns, gone, self._absences)
        dives = [(tracks[row].robot_id, tracks[row].last_seen_ns) for row in away]
        for column, row in enumerate(ready):
            if row not in waiting:
                self._absences.add(gone[:, column], likely[:, column], dives)
        done = Returns(waiting=waiting)
        new, old = [ready[column] for column in columns], [away[i] for i in rows]
        for k, law in enumerate(chances.tolist()):
            done.label_probabilities[old[k]] = dict(zip(new, law, strict=True))
            if law[k] > TUNING.naming_probability:
                done.found[new[k]] = old[k]
            else:
                done.ended.add(old[k])
        if not settled:
            self._allow(done, away, ready, likely)
        return done

    def _allow(self, done: Returns, away: list[int], ready: list[int], likely: Array) -> None:
        """Note what else tracks may be that were named each by itself.

        Args:
            done: goes on with it.
            away: n rows of robots that may have been out of sight.
            ready: m rows of new tracks.
            likely: (n, m) probabilities.
        """
        for new in done.found:
            j = ready.index(new)
            for other, share in zip(away, likely[:, j].tolist(), strict=True):
                if other not in done.label_probabilities and share > TUNING.unsure_probability:
                    done.other[new, other] = share
            unknown = 1.0 - float(likely[:, j].sum())
            if unknown > TUNING.unsure_probability:
                done.unknown[new] = unknown

    def _densities(
        self,
        tracks: list[Track],
        away: list[int],
        unseen: Array,
        between: tuple[Array, Array],
        swims: VelocityLikelihood,
    ) -> tuple[Array, Array]:
        """Return the densities (n, m) of places, 1/m²; as stated, and in doubt by `doubt_m`."""
        offsets, spread = between
        density, vague = np.empty((2, *offsets.shape[:2]))
        more, find = TUNING.doubt_m**2 * np.eye(2), self._whereabouts.density
        for i, row in enumerate(away):
            density[i] = find(tracks[row], unseen[i], offsets[i], spread[i], swims)
            vague[i] = find(tracks[row], unseen[i], offsets[i], spread[i] + more, swims)
        return density, vague


def duplicate_tracks(
    tracks: list[Track], ready: list[int], between: tuple[Array, Array], threshold: float
) -> dict[int, int]:
    """Return tracks that are of one robot: by row of the one to go on, the row of the other.

    They lie inside one another's gate, and no image has shown both.

    Args:
        tracks: all of them.
        ready: m rows of tracks without names that have hits enough.
        between: offsets (m, m, 2) between them, m, and covariances (m, m, 2, 2), m².
        threshold: squared Mahalanobis distance at the edge of a gate.
    """
    squared, _ = mahalanobis(*between)
    found: dict[int, int] = {}
    for i, j in combinations(range(len(ready)), 2):
        rows = sorted((ready[i], ready[j]), key=lambda row: tracks[row].last_seen_ns)
        if (
            squared[i, j] <= threshold
            and _can_be(tracks[rows[0]], tracks[rows[1]])
            and not {*rows} & {*found, *found.values()}
        ):
            found[rows[1]] = rows[0]
    return found


def _labels(known: list[Track], new: list[Track]) -> tuple[Array, Array]:
    """Return how likely new tracks are robots (n, m), or others (m,), by the picture alone."""
    told = [track.labels or UNTOLD for track in new]
    factors = [[one.factor(robot.robot_id) for one in told] for robot in known]
    return np.array(factors), np.array([one.factor("") for one in told])


def _absence(old: Track, new: Track) -> float:
    """Return for how long a robot had dived if a new track is that robot, s.

    NaN if it left the view or came back into it.
    """
    if old.leaving_view or new.entered_view:
        return np.nan
    return max(0.0, (new.first_seen_ns - old.last_seen_ns) * 1e-9)


def _can_be(old: Track, new: Track) -> bool:
    return old.class_id == new.class_id and not old.coexisted(new)


def _waits(density: Array) -> NDArray[np.bool_]:
    """Return which columns (m,) two rows of (n, m) explain about as well."""
    if len(density) < 2:
        return np.zeros(density.shape[1], dtype=bool)
    second, best = np.sort(density, axis=0)[-2:]
    waits: NDArray[np.bool_] = (best > 0.0) & (best < ASSIGNMENT.clear_ratio * second)
    return waits
