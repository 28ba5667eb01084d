# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Receives what drones send, refuses what cannot be joined, and keeps the fleet up to date.

What one drone sends wrongly is refused with a sentence; the others go on.
"""

from __future__ import annotations

import contextlib
import math
from collections import Counter, deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.fleet.fleet import Fleet, refuse_unable
from aerial_gnss_ros.core.fleet.gaps import Gaps
from aerial_gnss_ros.core.fleet.history import TUNING as HISTORY
from aerial_gnss_ros.core.fleet.history import History
from aerial_gnss_ros.core.fleet.outbox import SECOND_NS, SentSighting
from aerial_gnss_ros.core.fleet.publication import FleetUpdate
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.errors import ConfigError, InputError
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum


@dataclass(frozen=True)
class ShoreTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    ahead_s: float = 3.0
    """How far a scene may be ahead of this computer's clock, s: as far as a latency is negative."""
    most_hz: int = 100
    """Greatest number of a drone's sightings in a second of flight, as an outbox holds."""
    most_read_hz: int = 300
    """Greatest number of a drone's messages that are read in a second: new ones, and as many again
    after an outage, some of which may come at once. Judged."""
    early: int = 100
    """Greatest number of sightings that wait for their drone's parameters."""


TUNING = ShoreTuning()


@dataclass
class Link:
    """What is known of a drone, and of what it sends.

    Attributes:
        drone: its name.
        source: its namespace.
        config: of its estimator.
        gaps: which of its sightings have arrived.
        refused: number of those not used, by reason.
        delay_s: from the newest scene to its arrival, by this computer's clock, s; NaN at first.
        newest_ns: time of the newest scene, ns; 0 at first.
        update: result of its last sighting; None at first.
        seen: that sighting; None at first.
    """

    drone: str
    source: str
    config: EstimatorConfig
    gaps: Gaps = field(default_factory=Gaps)
    refused: Counter[str] = field(default_factory=Counter)
    delay_s: float = math.nan
    newest_ns: int = 0
    update: FleetUpdate | None = None
    seen: Sighting | None = None
    rates: Counter[int] = field(default_factory=Counter)

    def floods(self, scene_ns: int) -> bool:
        """Count a sighting; return whether there are too many in its second of flight."""
        second = scene_ns // SECOND_NS
        self.rates[second] += 1
        oldest = self.newest_ns // SECOND_NS - round(HISTORY.kept_s) - 1
        for past in [one for one in self.rates if one < oldest]:
            del self.rates[past]
        return self.rates[second] > TUNING.most_hz


class Shore:
    """All drones of a fleet as they are received.

    Args:
        sources: their namespaces; the fleet has its drones in this order.
        share: prior share of the receivers' variance that is common to all.
        datum: origin of the frame `map`; None: that of the drone heard first.
        clock: returns the time of a clock that is never stepped, ns.

    Attributes:
        links: to the drones, by namespace.
        datum: the origin; None until it is known.
        history: the fleet; None until a drone is known.
        notes: what became of references, each kind of sentence once, and which drones have
            restarted, until it is taken.
    """

    def __init__(
        self,
        sources: Sequence[str],
        share: float,
        datum: MapDatum | None,
        clock: Callable[[], int],
    ) -> None:
        self._sources, self._share, self._clock = list(sources), share, clock
        self._early: dict[str, deque[tuple[SentSighting, int]]] = {}
        self._read: dict[str, tuple[int, int]] = {}
        self.datum = datum
        self._local: LocalMap | None = None
        self._now_ns = 0
        self.links: dict[str, Link] = {}
        self.history: History | None = None
        self.notes: list[str] = []
        self._said: set[str] = set()

    def describe(
        self, source: str, drone: str, config: EstimatorConfig, datum: MapDatum | None
    ) -> None:
        """Take in a drone's parameters; with a further drone, the fleet begins anew with 65 s.

        Args:
            source: its namespace.
            drone: its name.
            config: of its estimator.
            datum: origin of its frame `map`, if known.

        Raises:
            InputError: another drone has this name, or its configuration cannot be joined.
        """
        other = next((k for k, one in self.links.items() if one.drone == drone), source)
        if other != source:
            raise InputError(
                f"{source} and {other} both call themselves drone {drone}: give each its own "
                f"sightings.drone. {source} is refused."
            )
        try:
            refuse_unable(drone, config)
        except ConfigError as error:
            raise InputError(f"{error} It is refused.") from error
        former = self.links.get(source)
        known = former is not None and former.drone == drone and _same(former.config, config)
        if former is None or former.drone != drone:
            self.links[source] = Link(drone, source, config)
        else:
            former.config = config
        self.datum = self.datum or datum
        if self.datum is not None and not (known and self.history is not None):
            self._begin(self.datum)
        self._take_early()

    def _take_early(self) -> None:
        """Take in what came before the parameters; they are of two topics."""
        for source in [one for one in self._early if one in self.links]:
            if self.history is not None:
                for sent, now_ns in self._early.pop(source):
                    with contextlib.suppress(InputError):  # counted
                        self.add(source, sent, now_ns)

    def _begin(self, datum: MapDatum) -> None:
        """Make the fleet of all drones that are known, and give it what is kept."""
        self._local = self._local or LocalMap(datum)
        configs = {one.drone: one.config for one in self._known()}
        fleet = Fleet(configs, self._local, self._share)
        if self.history is None:
            self.history = History(fleet, list(configs), self._clock)
        else:
            fleet.follow(self.history.fleet)
            self.history.start_again(fleet, list(configs))

    def _known(self) -> list[Link]:
        return [self.links[source] for source in self._sources if source in self.links]

    def admit(self, source: str) -> None:
        """Count a message before it is read: that takes time, of which a flood has no right.

        Args:
            source: namespace that it comes from.

        Raises:
            InputError: there are too many in this second.
        """
        second = self._clock() // SECOND_NS
        before, count = self._read.get(source, (second, 0))
        count = count + 1 if before == second else 1
        self._read[source] = second, count
        if count > TUNING.most_read_hz:
            if source in self.links:
                self.links[source].refused["flood"] += 1
            raise InputError(
                f"it sends more than {TUNING.most_read_hz} messages a second: the others of this "
                "second are not read."
            )

    def add(self, source: str, sent: SentSighting, now_ns: int) -> None:
        """Take in a sighting.

        Args:
            source: namespace that it comes from.
            sent: itself.
            now_ns: time of this computer's clock, ns.

        Raises:
            InputError: it is refused; the sentence says why.
        """
        link = self.links.get(source)
        if link is None or self.history is None or self._local is None:
            kept = self._early.setdefault(source, deque(maxlen=TUNING.early))
            kept.append((sent, now_ns))
            return
        if link.drone != sent.drone:
            raise InputError(f"{source} is drone {link.drone}, but sends images of {sent.drone}.")
        scene_ns = sent.sighting.pose.stamp_ns
        ahead_s = (scene_ns - now_ns) / SECOND_NS
        if ahead_s > TUNING.ahead_s:  # not noted as received: it may be right in time
            raise _refusal(
                link,
                "clock_ahead",
                f"its clock is {ahead_s:.0f} s ahead of this computer's: set both by GNSS or NTP",
            )
        session = link.gaps.session
        if not link.gaps.take(sent):
            return
        if session is not None and link.gaps.session != session:
            self.notes.append(
                f"Drone {link.drone} has restarted: its names mean other robots until these are "
                "found to be the same."
            )
        reason, words = self._trouble(link, sent, self._local)
        if not reason and not self.history.add(sent):
            reason = "too_late"
            late_s = (now_ns - scene_ns) / SECOND_NS
            words = (
                f"it is older than the {HISTORY.kept_s:.0f} s that are kept, and {late_s:.0f} s "
                "old by this computer's clock: the drone's clock may be behind"
            )
        if reason:
            raise _refusal(link, reason, words)
        if scene_ns > link.newest_ns:
            link.newest_ns, link.delay_s = scene_ns, (now_ns - scene_ns) / SECOND_NS

    def follow_clock(self, now_ns: int) -> bool:
        """Begin anew if this computer's clock has gone backward; return whether it has.

        What was received is then of a time to come, and everything else would be too late for it.

        Args:
            now_ns: time of this computer's clock, ns.
        """
        before_ns, self._now_ns = self._now_ns, now_ns
        if now_ns >= before_ns - TUNING.ahead_s * SECOND_NS or self.datum is None:
            return False
        self.history = None
        self._early.clear()
        for source, link in self.links.items():
            self.links[source] = Link(link.drone, source, link.config)
        if self.links:
            self._begin(self.datum)
        return True

    def _trouble(self, link: Link, sent: SentSighting, local: LocalMap) -> tuple[str, str]:
        """Return why a sighting is refused, a word and a clause; empty if it is not."""
        pose = sent.sighting.pose
        place = local.positions([pose.latitude], [pose.longitude])[0]
        far_m, most_m = math.hypot(*place.tolist()), link.config.limits.origin_distance_m
        if not far_m <= most_m:
            return "other_site", (
                f"it is {far_m / 1000.0:.0f} km from the origin of map "
                f"(limits.origin_distance_m: {most_m / 1000.0:g} km)"
            )
        if link.floods(pose.stamp_ns):
            return "flood", f"it sends more than {TUNING.most_hz} images a second"
        return "", ""

    def advance(self) -> FrameResult | None:
        """Apply what has arrived; return the fleet's newest result, if there is a new one."""
        if self.history is None or self.datum is None:
            return None
        applied = self.history.advance()
        by_name = {one.drone: one for one in self.links.values()}
        for sent, update in applied:
            self._note(update)
            if sent.drone in by_name:
                by_name[sent.drone].update, by_name[sent.drone].seen = update, sent.sighting
        if not applied:
            return None
        sent, update = applied[-1]
        seen = sent.sighting
        return FrameResult(
            seen.stamp_ns,
            seen.frame_id,
            update.estimates,
            (),
            self.datum,
            seen.pose,
            platform=update.platform,
            boxes=len(seen.pixels),
            used=len(seen.pixels),
        )

    def _note(self, update: FleetUpdate) -> None:
        """Keep what an update says, unless it was said before the fleet went back."""
        for note in update.notes:
            kind = note.partition(":")[0]
            if kind not in self._said:
                self._said.add(kind)
                self.notes.append(note)

    def predicted(self, stamp_ns: int) -> FrameResult | None:
        """Return the robots predicted without an image; None before the first one.

        Args:
            stamp_ns: time of the prediction, on the images' clock, ns.
        """
        if self.history is None or self.datum is None:
            return None
        estimates = self.history.fleet.predicted(stamp_ns)
        return FrameResult(stamp_ns, "", estimates, (), self.datum)


def _refusal(link: Link, reason: str, words: str) -> InputError:
    """Count a refused sighting; return the error that says why."""
    link.refused[reason] += 1
    return InputError(f"an image of drone {link.drone} is refused: {words}.")


def _same(one: EstimatorConfig, other: EstimatorConfig) -> bool:
    """Return whether two configurations are the same for the fleet."""
    parts = ("noise", "gimbal", "tracks", "classes", "depth", "references")
    return all(repr(getattr(one, part)) == repr(getattr(other, part)) for part in parts)
