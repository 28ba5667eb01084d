# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Finds out which robots of different drones are one, and when one is nobody else's."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.fleet.constellations import Candidates, matchings
from aerial_gnss_ros.core.fleet.drone import Drone
from aerial_gnss_ros.core.fleet.robots import FleetRobot
from aerial_gnss_ros.core.fleet.shared_state import SharedState
from aerial_gnss_ros.core.models.platform_model import COUNT

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
_Sides = tuple[list[int], list[int], tuple[int | None, int | None]]
"""Places of robots of two sets, and the drone that does not show those of each."""


@dataclass(frozen=True)
class MatchingTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    every_s: float = 0.2
    """How often robots are matched, s: their covariances change no faster. Judged."""
    sure: float = 0.999
    """Probability of a pair, by all matchings that contain it, from which it is one robot: a wrong
    one is a confident wrong position, a late one costs precision. Judged."""
    sure_s: float = 1.0
    """Time for which it must be so sure, s. Judged."""
    apart: float = 0.95
    """Probability of being no other drone's robot from which one gets a name at once. Judged."""
    unnamed_s: float = 10.0
    """Time after which it gets a name all the same, s. Judged."""
    in_view: float = 0.8
    """Probability of being in the view of a drone from which it should show a robot. Judged."""
    fresh_s: float = 1.0
    """Time for which a drone that has measured a robot is taken to see it, s. Judged."""


TUNING = MatchingTuning()


class RobotMatching:
    """Joins robots of different drones.

    Args:
        drones: of the fleet, by number.
    """

    def __init__(self, drones: list[Drone]) -> None:
        self._drones = drones
        self._since: dict[tuple[int, int], int] = {}
        self._weighed_ns: int | None = None
        self._alone: set[int] = set()
        self._rivals: dict[int, Array] = {}

    def dropped(self, slots: list[int]) -> None:
        """Take note that robots were dropped and later ones have moved up.

        Args:
            slots: their places.
        """

        def moved(slot: int) -> int:
            return slot - sum(gone < slot for gone in slots)

        self._since = {
            (moved(i), moved(j)): since_ns
            for (i, j), since_ns in self._since.items()
            if i not in slots and j not in slots
        }
        self._alone = {moved(i) for i in self._alone if i not in slots}

    def update(
        self, state: SharedState, robots: list[FleetRobot], now_ns: int
    ) -> list[tuple[int, int]]:
        """Join robots that surely are one; return these pairs: the first of each is to be dropped.

        Args:
            state: the filter.
            robots: its robots.
            now_ns: time of the last scene, ns.
        """
        if self._weighed_ns is not None and now_ns - self._weighed_ns < TUNING.every_s * 1e9:
            return []
        self._weighed_ns = now_ns
        since: dict[tuple[int, int], int] = {}
        self._rivals = {}
        likely = {i: 0.0 for i, robot in enumerate(robots) if not robot.tentative}
        seen = [self.seeing(robot, now_ns) for robot in robots]
        for mine, others, views in self._sides(robots, seen):
            possible = np.array(
                [
                    [robots[i].class_id == robots[j].class_id and not seen[i] & seen[j]
                     for j in others]
                    for i in mine
                ], np.bool_,
            ).reshape(len(mine), len(others))  # fmt: skip
            for i, j in self._one(state, robots, possible, mine, others, views, likely):
                pair = (min(i, j), max(i, j))
                since[pair] = self._since.get(pair, now_ns)
        self._alone = {i for i, share in likely.items() if share < 1.0 - TUNING.apart}
        for i, robot in enumerate(robots):
            robot.note_rival(self._rivals.get(i), now_ns)
        self._since = since
        pairs = list[tuple[int, int]]()
        taken: set[int] = set()
        for (first, second), began_ns in since.items():
            if now_ns - began_ns < TUNING.sure_s * 1e9 or taken & {first, second}:
                continue
            taken |= {first, second}
            robots[second].join(robots[first])
            pairs.append((first, second))
        return pairs

    def nobody_else(self, slot: int, robots: list[FleetRobot], now_ns: int) -> bool:
        """Return whether a robot without a name is not, or has not been found to be, another's."""
        robot = robots[slot]
        rivals = any(
            other.class_id == robot.class_id and not {*other.labels} & {*robot.labels}
            for other in robots
            if other is not robot and not other.tentative
        )
        late = now_ns - robot.began_ns > TUNING.unnamed_s * 1e9
        return not rivals or late or slot in self._alone

    def seeing(self, robot: FleetRobot, now_ns: int) -> set[int]:
        """Return the drones that have measured a robot of late."""
        return robot.seen_within(now_ns, round(TUNING.fresh_s * 1e9))

    def others_see(self, drone: int, robot: FleetRobot, now_ns: int) -> bool:
        """Return whether any drone but one has measured a robot of late."""
        return bool(self.seeing(robot, now_ns) - {drone})

    def _sides(self, robots: list[FleetRobot], seen: list[set[int]]) -> Iterator[_Sides]:
        """Yield the sets of robots that are matched with one another.

        Drones are taken two by two, since with a third one each robot would have two candidates
        that are one. At the end, robots that a drone sees with those that no drone does and that
        this one has not known: whether they are those that it has, its own estimator decides.

        Args:
            robots: of the fleet.
            seen: the drones that see each of them.
        """
        count = len(self._drones)
        known = [i for i, robot in enumerate(robots) if not robot.tentative]
        for first in range(count):
            for second in range(first + 1, count):
                mine = [i for i in known if first in seen[i] and second not in seen[i]]
                others = [i for i in known if second in seen[i] and first not in seen[i]]
                yield mine, others, (second, first)
        for drone in range(count):
            mine = [i for i in known if drone in seen[i]]
            unseen = [i for i in known if not seen[i] and drone not in robots[i].labels]
            yield mine, unseen, (None, drone)

    def _one(
        self,
        state: SharedState,
        robots: list[FleetRobot],
        possible: NDArray[np.bool_],
        mine: list[int],
        others: list[int],
        views: tuple[int | None, int | None],
        likely: dict[int, float],
    ) -> list[tuple[int, int]]:
        """Return the pairs of two sets of robots that are one by a sure matching.

        Args:
            state: the filter.
            robots: its robots.
            possible: (m, n) whether two may be one.
            mine: places of m robots, and
            others: of n others.
            views: drones that do not show those of each set; None: nothing follows from that.
            likely: receives the probability with which each is one of the other set.
        """
        if not possible.any():
            return []
        sides = np.array([*mine, *others], np.intp)
        places, covariance = _of_robots(state, sides)
        candidates = Candidates.of(places, covariance, possible)
        blocks = np.einsum("iaib->iab", covariance)
        count = len(mine)
        in_view = [
            self._in_view(state, drone, places[side], blocks[side])
            for drone, side in zip(views, (slice(count), slice(count, None)), strict=True)
        ]
        shares: defaultdict[tuple[int, int], float] = defaultdict(float)
        each: defaultdict[int, float] = defaultdict(float)
        for weighed in matchings(candidates, *in_view):
            for a, b in weighed.pairs:
                shares[mine[a], others[b]] += weighed.probability
                each[mine[a]] += weighed.probability
                each[others[b]] += weighed.probability
        for i, share in each.items():
            likely[i] = max(likely[i], share)
        found = [pair for pair, share in shares.items() if share >= TUNING.sure]
        clear = possible & (np.minimum.outer(*in_view) > TUNING.in_view)
        one = {i for pair in found for i in pair}
        clear &= ~np.logical_or.outer([i in one for i in mine], [j in one for j in others])
        for a, b in np.argwhere(clear).tolist():
            self._contradict(robots, mine[a], others[b], places[count + b] - places[a])
        return found

    def _contradict(self, robots: list[FleetRobot], i: int, j: int, offset: Array) -> None:
        """Note two robots that are in view of each other's drone and that it does not show.

        Of one that more drones know nothing is said.
        """
        for one, other, apart in ((i, j, offset), (j, i, -offset)):
            known = self._rivals.get(one)
            nearer = known is None or float(apart @ apart) < float(known @ known)
            if nearer and len(robots[one].labels) <= len(robots[other].labels):
                self._rivals[one] = apart

    def _in_view(
        self, state: SharedState, drone: int | None, places: Array, blocks: Array
    ) -> Array:
        """Return the probabilities (n,) that robots are in a drone's view.

        Args:
            state: the filter.
            drone: number of the drone; None: nothing is known of its view.
            places: (n, 2) of the robots, East, North, m.
            blocks: (n, 2, 2) covariances of these, m².
        """
        if drone is None or not self._drones[drone].recent(self._weighed_ns or 0, TUNING.fresh_s):
            return np.zeros(len(places))
        errors = state.platform(drone)[0]
        return self._drones[drone].shows(errors, places, blocks)


def _of_robots(state: SharedState, slots: Indices) -> tuple[Array, Array]:
    """Return the places (k, 2) of some robots, and their covariance (k, 2, k, 2)."""
    own, k = (COUNT + 4 * slots[:, None] + np.arange(2)).ravel(), len(slots)
    covariance = state.joint.covariance[np.ix_(own, own)].reshape(k, 2, k, 2)
    return state.joint.robots[slots, :2], covariance
