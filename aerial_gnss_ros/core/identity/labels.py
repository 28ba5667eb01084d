# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Assigns labels to newly confirmed robots: a saved one, a bound one, or a new number."""

from __future__ import annotations

import copy
import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.assignment import assign
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, RobotBinding
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.identity.label_format import LabelRegistry, class_token
from aerial_gnss_ros.core.identity.saved_labels import SavedNames, SavedRobot
from aerial_gnss_ros.core.numerics.gaussian import gate_threshold, mahalanobis
from aerial_gnss_ros.core.numerics.linear_assignment import linear_sum_assignment
from aerial_gnss_ros.core.values.estimates import RobotEstimate
from aerial_gnss_ros.core.values.events import Events

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LabelsTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    max_restart_s: float = 3600.0
    """A label saved longer ago is not reassigned: the robot can be anywhere by then. It stays used.
    Judged."""
    max_remembered: int = 1000
    """Greatest number of robots kept for the state file; those unseen longest are dropped first.
    Judged."""
    new_at_first: float = 1.0
    """Expected number of new robots that surface in the first `tracks.coast_s` seconds, unless
    `robots` lists them: they may have dived before the first image. Judged."""
    new_later: float = 0.1
    """The same in any later `tracks.coast_s` seconds, when few can still be submerged. Judged."""
    most_boxes: int = 5000
    """Number of boxes whose labels another tracker has told that are kept: 30 s of 15 images a
    second with ten robots. Judged."""


TUNING = LabelsTuning()

Box = tuple[int, float, float]
"""Stamp of an image, ns, and centre of a box in it, px."""


@dataclass(frozen=True)
class ConfirmedTrack:
    """A robot that has just been confirmed.

    Attributes:
        class_id: class name as the detector gave it.
        stamp_ns: of the image, ns.
        position: (2,) East, North in `map`, m.
        covariance: (2, 2) of the position, the platform's share included, m².
        boxes: that showed it so far.
    """

    class_id: str
    stamp_ns: int
    position: Array
    covariance: Array
    boxes: tuple[Box, ...] = ()


class Labels:
    """Assigns labels and remembers where each robot was.

    Args:
        config: bindings, gate and motion of the robots.
        saved: labels from before a restart.
        log: receives a warning when a robot is numbered while a start position is still free.
    """

    def __init__(
        self,
        config: EstimatorConfig,
        saved: SavedNames | None = None,
        log: Events | None = None,
    ) -> None:
        self._log = log or Events()
        saved = saved or SavedNames()
        self._bindings = {binding.name: binding for binding in config.robots}
        self._start_radius_m = config.start_radius_m
        self._threshold = gate_threshold(config.tracks.gate_probability)
        self._class_of = config.robot_class
        self._coast_s = config.tracks.coast_s
        numbered = {robot.name for robot in saved.robots} - set(self._bindings)
        self._names = LabelRegistry(frozenset(self._bindings), dict(saved.numbers), numbered)
        self._waiting = {robot.name: robot for robot in saved.robots}
        self._known: dict[str, SavedRobot | RobotEstimate] = dict(self._waiting)
        self._told: dict[Box, str] = {}
        self._followed: set[str] = set()

    def beside(self) -> Labels:
        """Return labels for another tracker of the same images; numbers are issued once for both.

        It calls a robot as this tracker calls its boxes, see `tell`.
        """
        other = copy.copy(self)
        other.go_own_way()
        return other

    def go_own_way(self) -> None:
        """Share only the numbers with the labels that these were copied from."""
        self._waiting, self._known, self._told = dict(self._waiting), dict(self._known), {}
        self._followed = set()

    def tell(self, boxes: dict[Box, str]) -> None:
        """Note how another tracker calls the robots in some boxes."""
        self._told.update(boxes)
        for box in list(self._told)[: -TUNING.most_boxes]:
            del self._told[box]

    def adopted(
        self, shared: Mapping[tuple[str, str], int], classes: Mapping[str, str]
    ) -> dict[str, str]:
        """Return the labels that robots get whom another tracker calls otherwise, by their own.

        Each robot is called as the other tracker has called most of the boxes that showed it, each
        label once. Where its own label is another's then, it gets a number.

        Args:
            shared: number of boxes that showed one robot here and one there, by both labels.
            classes: of the robots here, by their labels.
        """
        own, theirs = (sorted({pair[side] for pair in shared}) for side in (0, 1))
        found: dict[str, str] = {}
        if shared:
            counts = np.array([[float(shared.get((a, b), 0)) for b in theirs] for a in own])
            rows, columns = linear_sum_assignment(-counts)
            for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
                if counts[row, column]:
                    found[own[row]] = theirs[column]
        for name in sorted(set(found.values()) - set(found)):
            if name in classes:
                found[name] = self._names.next(classes[name])
        self._followed = {*self._followed, *found.values()}
        found = {one: other for one, other in found.items() if one != other}
        self._known = {name: one for name, one in self._known.items() if name not in found}
        return found

    def reconfigure(self, config: EstimatorConfig) -> None:
        """Use the speeds of another configuration's classes from now on."""
        self._class_of = config.robot_class

    def assign(self, sightings: list[ConfirmedTrack], local: LocalMap) -> list[str]:
        """Return a label for each robot confirmed in one image.

        Labels that another tracker has told take precedence over saved ones, these over bound ones,
        and bound ones over numbers.
        """
        given: dict[int, str] = {}
        self._follow(sightings, given)
        self._take_up(sightings, given, local)
        self._bind(sightings, given, local)
        for i, sighting in enumerate(sightings):
            if i not in given:
                given[i] = self._names.next(sighting.class_id)
                self._tell(given[i], sighting, local)
        return [given[i] for i in range(len(sightings))]

    def newcomers(self, seconds: float) -> float:
        """Return the expected number of new robots that surface within `tracks.coast_s`.

        If `robots` lists them, only those not seen yet are expected.

        Args:
            seconds: since the first image, s.
        """
        if self._bindings:
            return float(len(list(self._names.free_bound())))
        return TUNING.new_at_first if seconds <= self._coast_s else TUNING.new_later

    def remember(self, estimates: Iterable[RobotEstimate]) -> None:
        """Keep the robots' present positions for the state file."""
        for estimate in estimates:
            self._known[estimate.robot_id] = estimate
        while len(self._known) > TUNING.max_remembered:
            del self._known[min(self._known, key=lambda name: self._known[name].last_seen_ns)]

    def release(self) -> None:
        """Forget saved positions and release bound labels: the clock went backward."""
        self._waiting.clear()
        self._names.release_bound()

    def expect(self, estimates: Iterable[RobotEstimate]) -> None:
        """Reassign the labels of lost tracks to robots that reappear near their last positions.

        As after a restart, only the last position and its uncertainty are known.
        """
        for estimate in estimates:
            self._waiting[estimate.robot_id] = _saved_robot(estimate)
        self._names.release(self._waiting)

    def saved(self, shift_ns: int = 0) -> SavedNames:
        """Return everything that is saved for a restart.

        Args:
            shift_ns: offset subtracted from all stamps, ns: the clock may have been set
                (`TimeBase`).
        """
        robots = tuple(
            known if isinstance(known, SavedRobot) else _saved_robot(known)
            for known in self._known.values()
        )
        if shift_ns:
            robots = tuple(replace(one, last_seen_ns=one.last_seen_ns - shift_ns) for one in robots)
        return SavedNames(robots, dict(self._names.numbers))

    def _follow(self, sightings: list[ConfirmedTrack], given: dict[int, str]) -> None:
        """Call robots as another tracker has called most of their boxes; each label once."""
        if not self._told:
            return
        for i, sighting in enumerate(sightings):
            names = Counter(self._told[box] for box in sighting.boxes if box in self._told)
            if not names:
                continue
            ((name, _),) = names.most_common(1)
            if name not in self._followed:
                self._followed = {*self._followed, name}
                self._waiting.pop(name, None)
                given[i] = name

    def _take_up(
        self, sightings: list[ConfirmedTrack], given: dict[int, str], local: LocalMap
    ) -> None:
        waiting = list(self._waiting.values())
        if not waiting or not sightings:
            return
        latitude = np.array([robot.latitude for robot in waiting])
        longitude = np.array([robot.longitude for robot in waiting])
        spread, allowed = self._reach(waiting, sightings)
        allowed[:, list(given)] = False
        offsets = _offsets(local.positions(latitude, longitude), sightings)
        squared, log_determinant = mahalanobis(offsets, spread)
        allowed &= squared <= self._threshold
        rows, columns = assign(squared, log_determinant, allowed, self._threshold)
        for row, column in zip(rows, columns, strict=True):
            name = waiting[row].name
            given[int(column)] = name
            self._names.reserve(name)
            del self._waiting[name]

    def _reach(
        self, waiting: list[SavedRobot], sightings: list[ConfirmedTrack]
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Return covariances (n, m, 2, 2) of saved to new positions and the possible pairs.

        The receiver may have restarted, so the platform's errors are independent. A robot moves as
        a coasting one, but no faster than its class allows.
        """
        spread = np.zeros((len(waiting), len(sightings), 2, 2))
        allowed = np.zeros(spread.shape[:2], dtype=bool)
        for i, robot in enumerate(waiting):
            for j, sighting in enumerate(sightings):
                unseen = max(0.0, (sighting.stamp_ns - robot.last_seen_ns) * 1e-9)
                moves = self._class_of(robot.class_id)
                wander = moves.acceleration * math.sqrt(unseen**3 / 3.0)
                motion = min(wander, moves.max_speed * unseen)
                spread[i, j] = sighting.covariance + np.eye(2) * (robot.sigma_m**2 + motion**2)
                same = robot.class_id == sighting.class_id
                allowed[i, j] = same and unseen <= TUNING.max_restart_s
        return spread, allowed

    def _tell(self, name: str, sighting: ConfirmedTrack, local: LocalMap) -> None:
        """Warn, once for each start position, that it is free while a robot gets a number."""
        free = [self._bindings[bound] for bound in self._names.free_bound()]
        if not free:
            return
        apart = np.linalg.norm(_starts(free, local) - sighting.position, axis=1)
        start, metres = free[int(np.argmin(apart))], float(apart.min())
        if metres > self._start_radius_m:
            why = f"start_radius_m allows {self._start_radius_m:g} m"
        else:
            why = f"it is of class {sighting.class_id!r}, and {start.class_id!r} is expected there"
        self._log.warn_once(
            f"start {start.name}",
            f"A robot {metres:.0f} m from the start of {start.name} is labelled {name}: {why}. If "
            f"it is {start.name}, correct robots.{start.name} in the parameters.",
        )

    def _bind(
        self, sightings: list[ConfirmedTrack], given: dict[int, str], local: LocalMap
    ) -> None:
        free = [self._bindings[name] for name in self._names.free_bound()]
        open_ones = [i for i in range(len(sightings)) if i not in given]
        if not free or not open_ones:
            return
        rest = [sightings[i] for i in open_ones]
        squared = np.sum(_offsets(_starts(free, local), rest) ** 2, axis=-1)
        near = squared <= self._start_radius_m**2
        near &= np.array([[_same_class(binding, one) for one in rest] for binding in free])
        rows, columns = assign(squared, np.zeros_like(squared), near, self._start_radius_m**2)
        for row, column in zip(rows, columns, strict=True):
            name = free[row].name
            given[open_ones[column]] = name
            self._names.reserve(name)
            self._waiting.pop(name, None)


def _same_class(binding: RobotBinding, sighting: ConfirmedTrack) -> bool:
    return class_token(binding.class_id) == class_token(sighting.class_id)


def _starts(bindings: list[RobotBinding], local: LocalMap) -> Array:
    """Return the start positions, East, North (n, 2) in `map`, m."""
    return local.positions(
        np.array([binding.latitude for binding in bindings]),
        np.array([binding.longitude for binding in bindings]),
    )


def _offsets(places: Array, sightings: list[ConfirmedTrack]) -> Array:
    """Return offsets (n, m, 2) from each start to each sighting, m."""
    offsets: Array = np.array([one.position for one in sightings])[None] - places[:, None]
    return offsets


def _saved_robot(estimate: RobotEstimate) -> SavedRobot:
    return SavedRobot(
        estimate.robot_id,
        estimate.class_id,
        estimate.latitude,
        estimate.longitude,
        estimate.last_seen_ns,
        estimate.sigma,
    )
