# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Applies sightings in the order of their scenes, whatever order they arrive in.

The fleet's filter takes images in the order of time. So that a late one is used at its own time,
all sightings of the last 65 s are kept, with a copy of the fleet about each second: the last copy
before the late sighting is taken up again, and everything since then is applied once more. Order
and result are those of a flight in which nothing was late, to the last bit.

Going back costs the more the farther back it is. Late sightings are therefore collected for as
long as the last time of going back has taken, and for half a second at least.
"""

from __future__ import annotations

import copy
from bisect import bisect_left, insort
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from aerial_gnss_ros.core.estimation.attempt import attempt
from aerial_gnss_ros.core.fleet.fleet import Fleet
from aerial_gnss_ros.core.fleet.outbox import SECOND_NS, SentSighting
from aerial_gnss_ros.core.fleet.publication import FleetUpdate

TOO_LATE = "too_late"
FAILED = "failed"


@dataclass(frozen=True)
class HistoryTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    kept_s: float = 65.0
    """Time for which sightings are kept, s: an outage of 60 s, and what it takes to notice and to
    make up for it."""
    copied_s: float = 1.0
    """Time between two copies of the fleet, s: a copy costs as much as a few sightings. Judged."""
    collected_s: float = 0.5
    """Least time from one time of going back to the next, s."""


TUNING = HistoryTuning()

_Key = tuple[int, str, int, int]
_BEGINNING: _Key = (-1, "", 0, 0)


@dataclass
class _Copy:
    """The fleet before the first sighting whose key is not less than one.

    Attributes:
        key: of that sighting.
        fleet: itself; it is copied again when it is taken up.
        sessions: of each drone's last sighting.
    """

    key: _Key
    fleet: Fleet
    sessions: dict[str, int]


class History:
    """Sightings of the last 65 s, and the fleet after them.

    Args:
        fleet: before its first sighting.
        drones: their names, in the order of the fleet.
        clock: returns the time of a clock that is never stepped, ns.

    Attributes:
        fleet: after all sightings that are applied.
        refused: sightings that were not used: `too_late` for what is kept, or `failed`.
        applied: number of sightings applied, again and again as often as that was.
        returned: how often it has gone back.
        failures: what the last ones raised, until they are taken.
    """

    def __init__(self, fleet: Fleet, drones: Sequence[str], clock: Callable[[], int]) -> None:
        self._clock = clock
        self._drones = list(drones)
        self._begin(fleet)
        self._known: list[tuple[_Key, SentSighting]] = []  # applied, or to be applied again
        self._waiting: list[tuple[_Key, SentSighting]] = []
        self._newest_ns = 0
        self._pause_until_ns: int | None = None
        self.refused: Counter[str] = Counter()
        self.applied = self.returned = 0
        self.failures: list[Exception] = []

    def _begin(self, fleet: Fleet) -> None:
        self.fleet, self._sessions = fleet, dict[str, int]()
        self._last = _BEGINNING
        self._copies = [_Copy(_BEGINNING, copy.deepcopy(fleet), {})]

    @property
    def waiting(self) -> int:
        """Number of sightings that have arrived and are not applied yet."""
        return len(self._waiting)

    def start_again(self, fleet: Fleet, drones: Sequence[str]) -> None:
        """Take up another fleet at the beginning of what is kept, such as with a further drone."""
        self._drones = list(drones)
        self._begin(fleet)
        kept = [one for one in self._known + self._waiting if one[1].drone in self._drones]
        self._waiting, self._known = sorted(kept, key=_by_key), []

    def add(self, sent: SentSighting) -> bool:
        """Take in a sighting, each of them once; return False if it is too late."""
        scene_ns = sent.sighting.pose.stamp_ns
        key = (scene_ns, sent.drone, sent.session, sent.sequence)
        oldest_ns = self._newest_ns - round(TUNING.kept_s * SECOND_NS)
        if scene_ns < oldest_ns or key < self._copies[0].key:
            self.refused[TOO_LATE] += 1
            return False
        self._newest_ns = max(self._newest_ns, scene_ns)
        insort(self._waiting, (key, sent), key=_by_key)
        return True

    def advance(self) -> list[tuple[SentSighting, FleetUpdate]]:
        """Apply what has arrived; return it with the results, the newest last.

        That one alone has estimates: positions are published after all that has arrived.
        """
        began_ns = self._clock()
        gone = bisect_left(self._waiting, self._copies[0].key, key=_by_key)
        if gone:  # the history has moved on while they waited
            self.refused[TOO_LATE] += gone
            del self._waiting[:gone]
        first = bisect_left(self._waiting, self._last, key=_by_key)
        late, fresh = self._waiting[:first], self._waiting[first:]
        back = bool(late) and (self._pause_until_ns is None or began_ns >= self._pause_until_ns)
        if back:
            fresh, late = self._gone_back(late) + fresh, []
        self._waiting = late
        found = self._apply(fresh)
        self._forget()
        if back:
            ended_ns = self._clock()
            least_ns = round(TUNING.collected_s * SECOND_NS)
            self._pause_until_ns = max(began_ns + least_ns, 2 * ended_ns - began_ns)
        return found

    def _gone_back(self, late: list[tuple[_Key, SentSighting]]) -> list[tuple[_Key, SentSighting]]:
        """Take up the copy before late sightings; return all that follow it."""
        self.returned += 1
        self._take_up(late[0][0])
        begin = bisect_left(self._known, self._copies[-1].key, key=_by_key)
        again = sorted(self._known[begin:] + late, key=_by_key)
        del self._known[begin:]
        return again

    def _take_up(self, key: _Key) -> None:
        """Take up the last copy that is not later than a sighting."""
        while self._copies[-1].key > key:
            del self._copies[-1]
        last = self._copies[-1]
        self.fleet = copy.deepcopy(last.fleet)
        self._sessions, self._last = dict(last.sessions), last.key

    def _apply(
        self, sightings: list[tuple[_Key, SentSighting]]
    ) -> list[tuple[SentSighting, FleetUpdate]]:
        """Apply sightings, which are in order and follow what is applied."""
        found: list[tuple[SentSighting, FleetUpdate]] = []
        todo = sightings
        while todo:
            for place, (key, sent) in enumerate(todo):
                update = self._one(key, sent, publish=place + 1 == len(todo))
                if update is None:  # what it has left behind is not used
                    self.refused[FAILED] += 1
                    self._take_up(key)
                    begin = bisect_left(self._known, self._last, key=_by_key)
                    again = self._known[begin:]
                    del self._known[begin:]
                    todo = again + todo[place + 1 :]
                    if not todo:
                        found.clear()  # none of them has estimates
                    break
                self._known.append((key, sent))
                found.append((sent, update))
            else:
                todo = []
        return found

    def _one(self, key: _Key, sent: SentSighting, publish: bool) -> FleetUpdate | None:
        """Apply one sighting, and publish positions; return None if that fails."""
        last = self._copies[-1].key
        if last is _BEGINNING or key[0] - last[0] >= TUNING.copied_s * SECOND_NS:
            self._copies.append(_Copy(key, copy.deepcopy(self.fleet), dict(self._sessions)))
        if self._sessions.get(sent.drone, sent.session) != sent.session:
            number = self._drones.index(sent.drone)  # it has restarted: other names, other robots
            for robot in self.fleet.table.robots:
                robot.release(number)
        self._sessions[sent.drone] = sent.session
        self.applied += 1
        self._last = key
        update = attempt(self.fleet.update, sent.drone, sent.sighting, publish)
        if isinstance(update, Exception):
            self.failures.append(update)
            return None
        return update

    def _forget(self) -> None:
        """Forget what is older than the history; a copy from before its beginning stays."""
        oldest_ns = self._newest_ns - round(TUNING.kept_s * SECOND_NS)
        while len(self._copies) > 1 and self._copies[1].key[0] <= oldest_ns:
            del self._copies[0]
        del self._known[: bisect_left(self._known, self._copies[0].key, key=_by_key)]


def _by_key(one: tuple[_Key, SentSighting]) -> _Key:
    return one[0]
