# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A drone's sightings with sequence numbers, kept for a while so that they can be sent again."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace

from aerial_gnss_ros.core.fleet.sighting import Sighting

SECOND_NS = 1_000_000_000


@dataclass(frozen=True)
class OutboxTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    kept_s: float = 64.0
    """Time for which a sighting can be sent again, s: an outage of 60 s, and what it takes to ask
    for it; the fleet keeps a second more."""
    most: int = 6400
    """Greatest number of them: 64 s at 100 images a second."""
    backward_s: float = 3.0
    """How far scenes may go backward within a session, s: as far as a latency can change."""


TUNING = OutboxTuning()


@dataclass(frozen=True)
class SentSighting:
    """A sighting on its way from a drone to the fleet.

    Attributes:
        drone: name of the drone.
        session: time of its first scene, ns; a later one means that names and sequence numbers
            begin anew.
        sequence: number of the sighting in this session, from 0.
        oldest: least sequence number that can still be sent again.
        sighting: itself.
    """

    drone: str
    session: int
    sequence: int
    oldest: int
    sighting: Sighting


class Outbox:
    """Numbers a drone's sightings and keeps the last 64 s; the oldest is given up first.

    A clock that goes backward begins a session: what was sent cannot be joined with what follows.

    Args:
        drone: name of the drone.
    """

    def __init__(self, drone: str) -> None:
        self._drone = drone
        self._session = self._next = 0
        self._kept: deque[SentSighting] = deque(maxlen=TUNING.most)

    def add(self, seen: Sighting) -> SentSighting:
        """Number a sighting, keep it, and return it as it is sent."""
        scene_ns, kept = seen.pose.stamp_ns, self._kept
        if not kept or scene_ns < kept[-1].sighting.pose.stamp_ns - TUNING.backward_s * SECOND_NS:
            kept.clear()
            self._session, self._next = scene_ns, 0
        kept.append(SentSighting(self._drone, self._session, self._next, 0, seen))
        self._next += 1
        while scene_ns - kept[0].sighting.pose.stamp_ns > TUNING.kept_s * SECOND_NS:
            kept.popleft()
        return replace(kept[-1], oldest=kept[0].sequence)

    def between(self, session: int, first: int, last: int) -> list[SentSighting]:
        """Return what is kept of the sightings from one sequence number of a session to another."""
        if not self._kept or session != self._session:
            return []
        start = self._kept[0].sequence
        return [
            replace(self._kept[k - start], oldest=start)
            for k in range(max(first, start), min(last + 1, self._next))
        ]
