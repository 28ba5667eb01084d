# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The fleet's robots: their names, and by which names each drone knows them."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.identity.label_format import LabelRegistry

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RobotsTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    contradicted_s: float = 3.0
    """Time for which a drone must show another robot in the place of one, s: longer than robots of
    two drones take to be found to be one. Judged."""


TUNING = RobotsTuning()


@dataclass
class FleetRobot:
    """One robot; its state is at the same place in `SharedState.joint`.

    Attributes:
        class_id: class name as the detector gave it.
        began_ns: time of its first box, ns.
        last_seen_ns: of the last one, by any drone, ns.
        name: the fleet's; empty while it may be another drone's robot.
        labels: each drone's own name of it, by number of the drone.
        tracks: number of each drone's track of it.
        seen_ns: when each drone measured it last, ns.
        doubt: (2, 2) by which each drone widens its own position, m².
        refused: consecutive boxes of each drone that contradicted it.
        rival: (2,) offset to the nearest robot that a drone shows in its place, East, North, m;
            None without one.
        rival_ns: since when there has been one, ns.
    """

    class_id: str
    began_ns: int
    last_seen_ns: int
    name: str = ""
    labels: dict[int, str] = field(default_factory=dict)
    tracks: dict[int, int] = field(default_factory=dict)
    seen_ns: dict[int, int] = field(default_factory=dict)
    doubt: dict[int, Array] = field(default_factory=dict)
    refused: dict[int, int] = field(default_factory=dict)
    rival: Array | None = None
    rival_ns: int = 0

    @property
    def robot_id(self) -> str:
        """The fleet's name, as a track has one."""
        return self.name

    @property
    def tentative(self) -> bool:
        """Whether no drone has confirmed it yet."""
        return not self.labels and not self.name

    def note_track(self, drone: int, track: int, label: str) -> None:
        """Note which track of a drone it is, and the drone's label once it has one."""
        self.tracks[drone] = track
        if label:
            self.labels[drone] = label

    def release(self, drone: int) -> None:
        """Note that a drone's boxes are another robot's."""
        self.labels.pop(drone, None)
        self.tracks.pop(drone, None)
        self.refused.pop(drone, None)

    def measured(self, drone: int, stamp_ns: int, doubt: Array) -> None:
        """Note that a drone's box has measured it."""
        self.last_seen_ns = self.seen_ns[drone] = stamp_ns
        self.doubt[drone], self.refused[drone] = doubt, 0

    def join(self, other: FleetRobot) -> None:
        """Become one with another record of the same robot, whose name is the older one."""
        older = self if self.began_ns <= other.began_ns else other
        self.name = older.name or self.name or other.name
        self.began_ns = min(self.began_ns, other.began_ns)
        self.last_seen_ns = max(self.last_seen_ns, other.last_seen_ns)
        self.labels = other.labels | self.labels
        self.tracks = other.tracks | self.tracks
        self.refused = other.refused | self.refused
        for drone, seen_ns in other.seen_ns.items():
            if seen_ns > self.seen_ns.get(drone, -1):
                self.seen_ns[drone] = seen_ns
                if drone in other.doubt:
                    self.doubt[drone] = other.doubt[drone]

    def seen_within(self, now_ns: int, patience_ns: int) -> set[int]:
        """Return the drones that have measured it within some time."""
        return {one for one, seen_ns in self.seen_ns.items() if now_ns - seen_ns <= patience_ns}

    def note_rival(self, offset: Array | None, now_ns: int) -> None:
        """Note the nearest robot that a drone shows in its place, or that there is none."""
        if offset is None or self.rival is None:
            self.rival_ns = now_ns
        self.rival = offset

    def contradicted(self, now_ns: int) -> bool:
        """Return whether a drone has shown another robot in its place for a while."""
        return self.rival is not None and now_ns - self.rival_ns >= TUNING.contradicted_s * 1e9

    def widening(self, now_ns: int, wrong: AbstractSet[int] = frozenset()) -> Array:
        """Return the covariance (2, 2) that doubts add, m².

        That is the largest of its drones' own, and where one of two drones must be wrong, the
        spread of their robots.

        Args:
            now_ns: time of the last scene, ns.
            wrong: drones whose fault is known: they doubt themselves, but what is wrong has been
                allowed for. What they say counts where no other drone has the robot.
        """
        nothing = np.zeros((2, 2))
        doubts = [one for drone, one in self.doubt.items() if drone not in wrong]
        doubts = doubts or [*self.doubt.values()]
        own = max(doubts, key=lambda one: float(one[0, 0] + one[1, 1]), default=nothing)
        if self.rival is None or not self.contradicted(now_ns):
            return own
        found: Array = own + np.outer(self.rival, self.rival)
        return found


@dataclass(frozen=True)
class Recognised:
    """Which robots the boxes of a sighting are.

    Attributes:
        slots: places of the robots by box.
        new: boxes of none.
        again: place of each robot that has come back to its drone, and that of the tentative one
            as which it did.
    """

    slots: dict[int, int]
    new: list[int]
    again: list[tuple[int, int]]


def recognise(robots: list[FleetRobot], drone: int, seen: Sighting) -> Recognised:
    """Return which robots a drone's boxes are: those of its labels, else those of its tracks.

    Args:
        robots: of the fleet.
        drone: number of the drone.
        seen: its sighting.
    """
    labelled = {robot.labels[drone]: k for k, robot in enumerate(robots) if drone in robot.labels}
    tracked = {robot.tracks[drone]: k for k, robot in enumerate(robots) if drone in robot.tracks}
    found = Recognised({}, [], [])
    for box, (label, track) in enumerate(zip(seen.labels, seen.tracks, strict=True)):
        slot, before = labelled.get(label), tracked.get(track)
        if slot is None and before is not None and drone not in robots[before].labels:
            slot = before
        elif slot is not None and before not in (None, slot) and robots[before].tentative:
            found.again.append((slot, before))
            slot = before
        if slot is None:
            found.new.append(box)
        else:
            found.slots[box] = slot
    return found


class Names:
    """Issues the fleet's names: a drone's own where it is free, else the next of the class."""

    def __init__(self) -> None:
        self._registry = LabelRegistry()
        self._former: dict[tuple[int, str], str] = {}

    @property
    def taken(self) -> set[str]:
        """Names issued so far."""
        return self._registry.taken

    def follow(self, taken: set[str], former: dict[tuple[int, str], str]) -> None:
        """Go on with the names of a fleet that begins anew.

        Args:
            taken: names that it has issued, which mean no other robots now.
            former: its names, by number of a drone and that one's own name.
        """
        self._former = dict(former)
        for name in taken:
            self._registry.reserve(name)

    def issue(self, robot: FleetRobot) -> str:
        """Return a name for a robot."""
        for key in robot.labels.items():
            if key in self._former:
                name = self._former[key]
                self._former = {k: other for k, other in self._former.items() if other != name}
                return name
        for label in robot.labels.values():
            if label not in self._registry.taken:
                self._registry.reserve(label)
                return label
        return self._registry.next(robot.class_id)
