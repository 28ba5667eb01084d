# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Re-identification: which robot out of view a newly confirmed track is, if any.

The gate of a coasting robot grows with the time out of view, and so does the chance that what
surfaces there is another robot. The likelihood that the track is that robot is therefore compared
with that of a new one. New robots appear at a rate, so a robot unseen for seconds competes with
fewer of them than one unseen for minutes. The position density of a robot out of view is a mixture
(`return_position`), and its absence has a learnt distribution (`return_time`).

If a track could be either of two robots, the decision waits: once the other one surfaces too, their
relative position distinguishes them, whatever error they share. One image must show both, since a
robot that missed a box or two may have started a second track. If relative positions do not decide,
both tracks get new labels and the old ones end, as no later image could decide. If the other one
does not surface and no robot is likely enough, the track gets a new label.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.assignment import cheapest
from aerial_gnss_ros.core.association.image_labels import NO_EVIDENCE
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.identity.return_permutation import likeliest_permutation
from aerial_gnss_ros.core.identity.return_position import ReturnPosition, VelocityLikelihood
from aerial_gnss_ros.core.identity.return_time import AbsenceTimes
from aerial_gnss_ros.core.models.evidence import TUNING as EVIDENCE
from aerial_gnss_ros.core.models.evidence import UNCLEAR
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class ReidentificationTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    view_heights: float = 2.0
    """Side length of the water in view, as a multiple of the camera's height. Judged."""
    doubt_m: float = 0.5
    """Position error beyond the filter's covariance that both robots are allowed, one sigma, m.
    Judged."""
    patience_s: float = 4.0
    """Longest wait for the other candidate to surface, s; tracks that start one after the other
    wait for the last one. Judged."""
    patience_share: float = 0.05
    """The wait is longer by this share of the time for which the nearest robot was unseen.
    Judged."""
    look_s: float = 1.0
    """Time after which the velocity of an ambiguous track is known, s. Judged."""
    naming_probability: float = 0.8
    """Probability above which a new track gets a robot's label, against all other robots and new
    ones. Below, it gets a new one: a label on the wrong robot is a confident wrong position, which
    is much worse. docs/results/identity.md compares other values."""


TUNING = ReidentificationTuning()


@dataclass
class Returns:
    """Decisions about new tracks and robots that were out of view.

    Attributes:
        robots: by row of a new track, the row of the robot that it is.
        waiting: rows of new tracks whose decision is deferred.
        ended: rows of robots that surfaced but cannot be evidence apart.
        label_probabilities: by row of a robot that surfaced, the probability of each new row to be
            that robot.
        other: by a new row and that of a robot out of view, the probability that they are the same.
        unknown: by new row, the probability that it is a new robot.
    """

    robots: dict[int, int] = field(default_factory=dict)
    waiting: set[int] = field(default_factory=set)
    ended: set[int] = field(default_factory=set)
    label_probabilities: dict[int, dict[int, float]] = field(default_factory=dict)
    other: dict[tuple[int, int], float] = field(default_factory=dict)
    unknown: dict[int, float] = field(default_factory=dict)


class Reidentification:
    """Compares newly confirmed tracks with robots out of view.

    Args:
        motion: motion model of robots out of view.
        threshold: squared Mahalanobis distance at the edge of a gate.
        coast_s: longest time a robot may be out of view, s.
    """

    def __init__(self, motion: MotionModel, threshold: float, coast_s: float) -> None:
        self._positions = ReturnPosition(motion)
        self._threshold = threshold
        self._absences = AbsenceTimes(coast_s)

    def reset(self) -> None:
        """Forget the absences observed so far."""
        self._absences.reset()

    def decide(
        self,
        tracks: list[Track],
        away: list[int],
        ready: list[int],
        between: tuple[Array, Array],
        velocities: VelocityLikelihood,
        stamp_ns: int,
        height: float,
        newcomers: float,
    ) -> Returns:
        """Decide which new tracks are which robots.

        Args:
            tracks: all of them.
            away: n rows of robots that may have been out of view.
            ready: m rows of new tracks.
            between: offsets (n, m, 2) from robots to new tracks, m, and covariances (n, m, 2, 2)
                as the filter has them, m².
            velocities: velocity likelihoods of the new tracks.
            stamp_ns: of the image, ns.
            height: of the camera above the water, m.
            newcomers: expected number of new robots within `coast_s`.
        """
        squared, _ = mahalanobis(*between)
        possible = (squared <= self._threshold) & _possible(tracks, away, ready)
        unseen = np.array([(stamp_ns - tracks[row].last_seen_ns) * 1e-9 for row in away])
        gone = np.array([[_absence(tracks[old], tracks[new]) for new in ready] for old in away])
        odds = self._absences.odds(gone)
        density, widened = self._densities(tracks, away, unseen, between, velocities)
        known, side = [tracks[row] for row in away], TUNING.view_heights * max(height, 1.0)
        fresh = self._positions.new_robot_density(known, between[0], side, velocities)
        labelled, other = _labels(known, [tracks[row] for row in ready])
        each = np.maximum(newcomers * self._absences.share(gone, unseen) * fresh * other, 1e-12)
        place = -2.0 * np.log(np.maximum(density * labelled, 1e-300) / each)
        rows, columns = cheapest(place - 2.0 * np.log(odds), possible, np.zeros(len(away)))
        widened = np.where(possible, odds * (widened * labelled), 0.0)
        # If all candidates have surfaced, their relative positions decide.
        settled = (possible.any(axis=1).sum() <= len(columns)) and len(columns) > 1
        settled &= _coexisted([tracks[ready[column]] for column in columns])
        likely = widened / (widened.sum(axis=0) + each)
        age = np.array([(stamp_ns - tracks[row].first_seen_ns) * 1e-9 for row in ready])
        if settled:
            pairs = (place, possible, rows, columns, gone, self._absences)
            waits = _unsettled(likeliest_permutation(*pairs)[1], columns, age)
        else:
            nearest = unseen[np.where(possible, squared, np.inf).argmin(axis=0)]
            waits = _undecided(likely.max(axis=0), _waits(widened), age, nearest)
        waiting = {row for row, one in zip(ready, waits, strict=True) if one}
        sure = [settled or one > TUNING.naming_probability for one in likely[rows, columns]]
        kept = [k for k, j in enumerate(columns) if sure[k] and ready[j] not in waiting]
        rows, columns = rows[kept], columns[kept]
        pairs = (place, possible, rows, columns, gone, self._absences)
        rows, probabilities = likeliest_permutation(*pairs)
        dives = [(one.robot_id, one.last_seen_ns) for one in known]
        for column in [column for column, row in enumerate(ready) if row not in waiting]:
            self._absences.add(gone[:, column], likely[:, column], dives)
        new, old = [ready[column] for column in columns], [away[i] for i in rows]
        done = _returns(new, old, probabilities, waiting)
        return done if settled else self._with_alternatives(done, away, ready, likely)

    def _with_alternatives(
        self, done: Returns, away: list[int], ready: list[int], likely: Array
    ) -> Returns:
        """Return decisions with alternative labels of tracks that were decided one by one.

        Args:
            done: the decisions, extended.
            away: n rows of robots that may have been out of view.
            ready: m rows of new tracks.
            likely: (n, m) probabilities.
        """
        for new in done.robots:
            j = ready.index(new)
            for other, share in zip(away, likely[:, j].tolist(), strict=True):
                if other not in done.label_probabilities and share > UNCLEAR:
                    done.other[new, other] = share
            unknown = 1.0 - float(likely[:, j].sum())
            if unknown > UNCLEAR:
                done.unknown[new] = unknown
        return done

    def _densities(
        self,
        tracks: list[Track],
        away: list[int],
        unseen: Array,
        between: tuple[Array, Array],
        velocities: VelocityLikelihood,
    ) -> tuple[Array, Array]:
        """Return position densities (n, m), 1/m²: as stated, and widened by `doubt_m`."""
        offsets, spread = between
        density, widened = np.empty((2, *offsets.shape[:2]))
        more, find = TUNING.doubt_m**2 * np.eye(2), self._positions.density
        for i, row in enumerate(away):
            density[i] = find(tracks[row], unseen[i], offsets[i], spread[i], velocities)
            widened[i] = find(tracks[row], unseen[i], offsets[i], spread[i] + more, velocities)
        return density, widened


def duplicate_tracks(
    tracks: list[Track], ready: list[int], between: tuple[Array, Array], threshold: float
) -> dict[int, int]:
    """Return duplicate tracks of one robot: by row of the one kept, the row of the other.

    Each is inside the other's gate, and no image has shown both.

    Args:
        tracks: all of them.
        ready: m rows of unlabelled tracks with enough hits.
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
    """Return likelihood factors of robots (n, m) and of new ones (m,) from the image alone."""
    evidence = [track.label_evidence or NO_EVIDENCE for track in new]
    factors = [[one.factor(robot.robot_id) for one in evidence] for robot in known]
    return np.array(factors), np.array([one.factor("") for one in evidence])


def _absence(old: Track, new: Track) -> float:
    """Return how long a robot was submerged if a new track is that robot, s.

    NaN if it left the view or entered it.
    """
    if old.leaving_view or new.entered_view:
        return np.nan
    return max(0.0, (new.first_seen_ns - old.last_seen_ns) * 1e-9)


def _coexisted(came: list[Track]) -> bool:
    """Return whether each of some tracks was there together with each other one."""
    return all(a.coexisted(b) for a, b in combinations(came, 2))


def _possible(tracks: list[Track], away: list[int], ready: list[int]) -> Mask:
    """Return which robots (n,) can be which new tracks (m,), (n, m)."""
    pairs = [[_can_be(tracks[old], tracks[new]) for new in ready] for old in away]
    return np.array(pairs, dtype=np.bool_)


def _unsettled(probabilities: Array, columns: Indices, age: Array) -> Mask:
    """Return which new tracks wait (m,), where all candidates have surfaced.

    Args:
        probabilities: (k, k) of robots and tracks in the likeliest order.
        columns: (k,) the tracks.
        age: (m,) since they were first seen, s.
    """
    waits = np.zeros(len(age), dtype=np.bool_)
    waits[columns] = probabilities.diagonal() < 1.0 - UNCLEAR
    waits &= age[columns].min() < TUNING.look_s
    return waits


def _undecided(best: Array, unclear: Mask, age: Array, nearest: Array) -> Mask:
    """Return which new tracks wait (m,): more images may identify them.

    Args:
        best: (m,) probability of the likeliest robot.
        unclear: (m,) whether two robots are about as likely.
        age: (m,) since they were first seen, s.
        nearest: (m,) how long the nearest robot has been out of view, s.
    """
    waits: Mask = (best > UNCLEAR) & (best < 1.0 - UNCLEAR) & (age < TUNING.look_s)
    waits |= unclear & (
        age[unclear].min(initial=np.inf) < TUNING.patience_s + TUNING.patience_share * nearest
    )
    return waits


def _returns(new: list[int], old: list[int], probabilities: Array, waiting: set[int]) -> Returns:
    """Return the labels of new tracks by their probabilities, (k, k) robots by tracks."""
    done = Returns(waiting=waiting)
    for k, law in enumerate(probabilities.tolist()):
        done.label_probabilities[old[k]] = dict(zip(new, law, strict=True))
        if law[k] > TUNING.naming_probability:
            done.robots[new[k]] = old[k]
        else:
            done.ended.add(old[k])
    return done


def _can_be(old: Track, new: Track) -> bool:
    return old.class_id == new.class_id and not old.coexisted(new)


def _waits(density: Array) -> NDArray[np.bool_]:
    """Return the columns (m,) that two rows of (n, m) explain about equally well."""
    if len(density) < 2:
        return np.zeros(density.shape[1], dtype=bool)
    second, best = np.sort(density, axis=0)[-2:]
    waits: NDArray[np.bool_] = (best > 0.0) & (best < EVIDENCE.clear_odds * second)
    return waits
