# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Re-identification: which robot out of view a newly confirmed track is, if any.

The gate of a coasting robot grows with the time out of view, and so does the chance that what
surfaces there is another robot. The likelihood that the track is that robot is therefore compared
with that of a new one. New robots appear at a rate, so a robot unseen for seconds competes with
fewer of them than one unseen for minutes. The position density of a robot out of view is a mixture
(`return_position`), and its absence has a learnt distribution (`return_time`).

All tracks are compared together, as no robot is on two of them (`return_assignment`). Once all
candidates are back, their relative positions distinguish them, whatever error they share. One image
must show them together, since a robot that missed a box or two may have started a second track. If
relative positions do not decide, they get new labels and the old ones end, as no later image could
decide.

If no robot is likely enough, a track gets a new label, which it has until it is clear which robot
it is (`return_rules`). What was known of that when it got it stays with it (`Track.may_be`), and is
compared together with what comes later: a track of the same place is that track, not a third robot.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.assignment import cheapest
from aerial_gnss_ros.core.association.image_labels import NO_EVIDENCE
from aerial_gnss_ros.core.association.track import EarlierLabel, Track
from aerial_gnss_ros.core.identity.return_assignment import Pairs, exclusive_probabilities
from aerial_gnss_ros.core.identity.return_permutation import likeliest_permutation
from aerial_gnss_ros.core.identity.return_position import ReturnPosition
from aerial_gnss_ros.core.identity.return_rules import sure, undecided, unsettled
from aerial_gnss_ros.core.identity.return_time import AbsenceTimes
from aerial_gnss_ros.core.identity.returns import ReturnCandidates, Returns, decided
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


TUNING = ReidentificationTuning()


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

    def decide(self, given: ReturnCandidates) -> Returns:
        """Decide which new tracks are which robots."""
        tracks, away = given.tracks, given.away
        opened = [row for row, track in enumerate(tracks) if track.may_be]
        pairs = _earlier(tracks, away, opened).beside(self._pairs(given))
        done = self._decide(given, [*opened, *given.ready], len(opened), pairs)
        labels = [robot.robot_id for robot in given.robots]
        for column, row in enumerate(given.ready, len(opened)):
            done.may_be[row] = pairs.of(column, labels)
        return done

    def _decide(
        self, given: ReturnCandidates, new: list[int], opened: int, pairs: Pairs
    ) -> Returns:
        """Decide which tracks are which robots.

        Args:
            given: the robots.
            new: m rows of tracks, those first that have new labels already.
            opened: number of these.
            pairs: how robots and tracks compare.
        """
        away, stamp_ns = given.away, given.stamp_ns
        named, came = np.arange(len(new)) < opened, [given.tracks[row] for row in new]
        rows, columns = cheapest(
            pairs.place - 2.0 * np.log(pairs.odds), pairs.possible, np.zeros(len(away))
        )
        # If all candidates have surfaced, their relative positions decide.
        settled = bool(pairs.possible.any(axis=1).sum() <= len(columns)) and len(columns) > 1
        settled = settled and _coexisted([came[column] for column in columns])
        likely = exclusive_probabilities(pairs.ratio)
        age = np.array([(stamp_ns - track.first_seen_ns) * 1e-9 for track in came])
        if settled:
            law = self._permuted(pairs, rows, columns)[1]
            waits = unsettled(law, columns, age)
        else:
            waits = undecided(likely, age, ~named, given.unseen_s, pairs.absence_s)
        waits &= ~named
        kept = np.flatnonzero(sure(likely, rows, columns, named, settled) & ~waits[columns])
        kept = kept[np.argsort(columns[kept])]  # those that have labels first
        rows, columns = rows[kept], columns[kept]
        rows, probabilities = self._permuted(pairs, rows, columns)
        dives = [(robot.robot_id, robot.last_seen_ns) for robot in given.robots]
        for column in range(len(new)):
            if column in columns or not (named[column] or waits[column]):
                self._absences.add(pairs.absence_s[:, column], likely[:, column], dives)
        waiting = {row for row, one in zip(new, waits.tolist(), strict=True) if one}
        done = decided([new[j] for j in columns], [away[i] for i in rows], probabilities, waiting)
        return done if settled else self._with_alternatives(done, away, new, likely)

    def _permuted(self, pairs: Pairs, rows: Indices, columns: Indices) -> tuple[Indices, Array]:
        """Return the likeliest rows (k,) for the columns, and probabilities (k, k)."""
        return likeliest_permutation(
            pairs.place, pairs.possible, rows, columns, pairs.absence_s, self._absences
        )

    def _pairs(self, given: ReturnCandidates) -> Pairs:
        """Return how the robots compare with the new tracks."""
        known, new = given.robots, [given.tracks[row] for row in given.ready]
        squared, _ = mahalanobis(*given.between)
        possible = (squared <= self._threshold) & _possible(known, new)
        gone = np.array([[_absence(robot, track) for track in new] for robot in known])
        odds = self._absences.odds(gone)
        density, widened = self._densities(given)
        side = TUNING.view_heights * max(given.height, 1.0)
        offsets, velocities = given.between[0], given.velocities
        fresh = self._positions.new_robot_density(known, offsets, side, velocities)
        labelled, other = _labels(known, new)
        share = self._absences.share(gone, given.unseen_s)
        each = np.maximum(given.newcomers * share * fresh * other, 1e-12)
        place = -2.0 * np.log(np.maximum(density * labelled, 1e-300) / each)
        likely = np.where(possible, odds * (widened * labelled), 0.0)
        # Which of the robots it is does not depend on how soon each would be expected back.
        whole = likely.sum(axis=0)
        rate = np.where(whole > 0.0, (likely * each).sum(axis=0) / np.maximum(whole, 1e-300), 1.0)
        return Pairs(possible, place, odds, likely / rate, gone)

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

    def _densities(self, given: ReturnCandidates) -> tuple[Array, Array]:
        """Return position densities (n, m), 1/m²: as stated, and widened by `doubt_m`."""
        offsets, spread = given.between
        density, widened = np.empty((2, *offsets.shape[:2]))
        more, find = TUNING.doubt_m**2 * np.eye(2), self._positions.density
        for i, (robot, unseen) in enumerate(zip(given.robots, given.unseen_s, strict=True)):
            density[i] = find(robot, unseen, offsets[i], spread[i], given.velocities)
            widened[i] = find(robot, unseen, offsets[i], spread[i] + more, given.velocities)
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


def _earlier(tracks: list[Track], away: list[int], opened: list[int]) -> Pairs:
    """Return the pairs (n, k) of robots and of tracks that may be one of them since earlier."""
    none = EarlierLabel(0.0, 1.0, 0.0, np.nan)
    found = [
        [
            tracks[new].may_be.get(tracks[old].robot_id, none)
            if _can_be(tracks[old], tracks[new])
            else none
            for new in opened
        ]
        for old in away
    ]
    every = np.array(found).reshape(len(away), len(opened), 4)
    place, odds, ratio, absence = np.moveaxis(every, -1, 0)
    return Pairs(ratio > 0.0, place, odds, ratio, absence)


def _possible(robots: list[Track], new: list[Track]) -> Mask:
    """Return which robots (n,) can be which new tracks (m,), (n, m)."""
    return np.array([[_can_be(old, one) for one in new] for old in robots], dtype=np.bool_)


def _can_be(old: Track, new: Track) -> bool:
    return old.class_id == new.class_id and not old.coexisted(new)
