# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""References in view: differential GNSS by camera.

The receiver's offset shifts drone and robots alike, so that robots do not make it observable. One
object of known position does. Which track it is (`candidates`, `stationarity`), and whether its
stated position is right, is decided by probabilities that are updated as the filter learns
(`hypotheses`). Once that is clear, the published positions are conditioned on the reference
(`position_law`), and widened by the hypotheses that remain. The filter itself never uses a
reference: one that turns out to be wrong leaves no trace.

Once no reference is in view, the last image that showed one still informs about receiver and
camera; that knowledge ages as `noise.correlation_time_s` states.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.moored_law import MooredLaw
from aerial_gnss_ros.core.filter.recalibration import CalibrationChange
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.references.candidates import (
    Candidate,
    Expected,
    NamedTrack,
    candidates_of,
    with_crowding,
)
from aerial_gnss_ros.core.references.hypotheses import Hypothesis, hypotheses
from aerial_gnss_ros.core.references.position_law import PlatformKnowledge, PositionLaw
from aerial_gnss_ros.core.references.reference_report import ReferenceReport
from aerial_gnss_ros.core.references.source import Source
from aerial_gnss_ros.core.references.stationarity import StationarityTest
from aerial_gnss_ros.core.values.events import Events

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ReferencesTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    sure: float = 0.995
    """Probability from which a track is taken to be a reference: one left out costs metres of
    stated uncertainty, a wrong one metres of error. Judged."""
    unsure: float = 0.95
    """Probability below which it is not any more. Judged."""
    weighed_every_s: float = 0.2
    """How often hypotheses are weighed: filter and offsets change no faster. Judged."""
    negligible: float = 1e-5
    """Probability below which a hypothesis widens nothing. Judged."""


TUNING = ReferencesTuning()


@dataclass(frozen=True)
class _Memory:
    """What references showed of the platform's errors when they were last in view.

    Attributes:
        known: of the platform's errors at that time.
        stamp_ns: of the image, ns.
        believed: (2 N,) jumps of the receivers that were accepted until then, m.
    """

    known: PlatformKnowledge
    stamp_ns: int
    believed: Array


_Correction = tuple[PositionLaw, PlatformKnowledge]
"""A law conditioned on references, and what these show of the platform's errors."""


class References:
    """Corrects what is published by objects of known position.

    Args:
        source: what is estimated without references.
        log: receives which track is which reference, and which reference is not used.

    Attributes:
        links: label of the track that each used reference is.
        in_view: whether the last image shows one of them.
        recognised: the same of another tracker of the same boxes, which was sure.
        report: what is said of each.
    """

    def __init__(self, source: Source, log: Events) -> None:
        self._source = source
        self.report = ReferenceReport(log)
        self.reset()

    def reset(self) -> None:
        """Forget everything but what was said."""
        self.links: dict[str, str] = {}
        self.in_view = False
        self.recognised: Mapping[str, str] = {}
        self._candidates: dict[str, Candidate] = {}
        self._moving: set[str] = set()
        self._stamp_ns = self._weighed_ns = -1
        self._doubt: Array | None = None
        self._stationarity = StationarityTest(self._source)
        self._in_view: list[tuple[Candidate, int]] = []
        self._later: PlatformKnowledge | None = None
        self._used: _Correction | None = None
        self._memory: _Memory | None = None

    def update(
        self,
        tracks: Sequence[NamedTrack],
        expected: Sequence[Expected],
        stamp_ns: int,
        waiting: AbstractSet[str] = frozenset(),
    ) -> None:
        """Decide again which tracks are references, after the filter's update by an image.

        Args:
            tracks: by row of the filter.
            expected: where references are at the time of the image.
            stamp_ns: of the image, ns.
            waiting: those that move of which only another drone's images say where they are.
        """
        if not expected and not self.links:
            self.in_view = False
            return
        self._stamp_ns = stamp_ns
        self._moving = {one.name for one in expected if one.moves} | waiting
        found = candidates_of(expected, stamp_ns, tracks, self.links)
        self._candidates = with_crowding(found, expected)
        for name in [one for one in self.links if one not in self._candidates.keys() | waiting]:
            del self.links[name]
        in_view = [one for one in self._candidates.values() if one.rows]
        if in_view and (self._stamp_ns - self._weighed_ns) * 1e-9 >= TUNING.weighed_every_s:
            self._weighed_ns = self._stamp_ns
            self._weigh(tracks, in_view)
        self._corrected(tracks, self._stamp_ns)

    def rename(self, names: Mapping[str, str]) -> None:
        """Give robots other labels: new ones by old ones; others stay."""
        self.links = {one: names.get(label, label) for one, label in self.links.items()}
        self._stationarity.rename(names)

    def forget(self, names: Sequence[str]) -> None:
        """Forget references that are no more, or are elsewhere now, and what they showed."""
        for name in names:
            self._unlink(name)
            self._candidates.pop(name, None)
            self.report.forget(name)
            self._stationarity.forget(name)
        if names:
            self._doubt, self._in_view = None, []
            self._memory = self._later = self._used = None
            self._weighed_ns = -1

    def recalibrate(self, change: CalibrationChange) -> None:
        """Refer what references showed of the platform to another calibration."""
        self._stationarity.restart()
        self._used = self._later = None
        if self._memory is not None:
            known = self._memory.known
            value = known.value - known.by_errors @ change.errors
            self._memory = replace(self._memory, known=replace(known, value=value))

    def apply(
        self, tracks: Sequence[NamedTrack], mean: Array, covariance: Array, stamp_ns: int
    ) -> tuple[Array, Array] | None:
        """Correct robots' states; return platforms' errors (9 N,) and their covariance, or None.

        Args:
            tracks: by row of the filter.
            mean: (n, 4) of all robots, changed in place, m, m/s.
            covariance: (n, 4, 4) likewise.
            stamp_ns: for which time they hold, ns.
        """
        if not self.links and self._memory is None:
            return None
        found = self._used if stamp_ns == self._stamp_ns else self._corrected(tracks, stamp_ns)
        if found is None:
            return None
        best, known = self._source.final(found[0]), found[1]
        for one in self._source.laws:
            law = best if one.rows is best.rows else self._source.final(one.given(known))
            mean[law.rows], covariance[law.rows] = law.states()
        if self._doubt is not None:
            covariance[:, :2, :2] += self._doubt
        return best.mean[: best.errors], best.covariance[: best.errors, : best.errors]

    def published(self, law: MooredLaw, base: JointState) -> tuple[Array, Array]:
        """Return states (n, 4) and covariances of another law's robots, corrected alike.

        Args:
            law: in which some robots stay or drift.
            base: the filter's own law of the same robots.
        """
        row_of = dict(zip(base.ids.tolist(), base.rows.tolist(), strict=True))
        rows = np.array([row_of.get(one, -1) for one in law.ids.tolist()], np.intp)
        whole = PositionLaw(rows, *law.jointly_published())
        found = self._corrections(whole)
        if self._used is not None:
            found.append((whole.given(self._used[1]), self._used[1]))
        own = [row for _, row in self._in_view]
        best = min(found, key=lambda one: _uncertainty(one[0], own))[0]
        mean, blocks = self._source.final(best).states()
        if self._doubt is not None:
            blocks = blocks.copy()
            blocks[:, :2, :2] += self._doubt
        return mean, blocks

    def turned(self, by_angles: Array, angles: Array) -> dict[int, Array]:
        """Return how uncertain (2, 2) a rotation of the camera leaves robots, by row, m².

        Robots are missing where no reference is in view.

        Args:
            by_angles: (n, 2, 3) derivatives of all robots' positions by the angles, m/rad.
            angles: (3, 3) covariance of the rotation, rad².
        """
        law = self._law([row for _, row in self._in_view])
        known = _known(law, self._in_view)
        if not known[0]:
            return {}
        found = law.turned(*known, by_angles, angles)
        return dict(zip(law.rows.tolist(), found, strict=True))

    def _corrected(self, tracks: Sequence[NamedTrack], stamp_ns: int) -> _Correction | None:
        """Return the law by references in view or by those that were, None: there are none.

        The better of the two, with what it shows of the platform's errors. References in view
        that show more than earlier ones are remembered.
        """
        now = stamp_ns == self._stamp_ns
        self._in_view = self._pairs(tracks, now)
        own = [row for _, row in self._in_view]
        law, memory, believed = self._law(own), self._memory, self._source.believed
        self._later = None
        if memory is not None and np.array_equal(memory.believed, believed):
            seconds = max((stamp_ns - memory.stamp_ns) * 1e-9, 0.0)
            self._later = memory.known.later(self._source.decay(seconds), self._source.stationary)
        found = self._corrections(law)
        self._used = min(found, key=lambda one: _uncertainty(one[0], own), default=None)
        if now:
            self.in_view = any(tracks[row].last_seen_ns == stamp_ns for row in own)
        if now and self.in_view and self._used is found[0]:
            self._memory = _Memory(found[0][1], stamp_ns, believed.copy())
        return self._used

    def _corrections(self, law: PositionLaw) -> list[_Correction]:
        """Return a law by references in view, if there are any, then by those that were."""
        found: list[_Correction] = []
        known = _known(law, self._in_view)
        if known[0]:
            found.append((law.known(*known), law.knowledge(*known)))
        if self._later is not None:
            found.append((law.given(self._later), self._later))
        return found

    def _weigh(self, tracks: Sequence[NamedTrack], candidates: list[Candidate]) -> None:
        """Decide which tracks references are, and whether their stated positions are right."""
        law = self._law([row for one in candidates for row in one.rows])
        inside = set(law.rows.tolist())
        candidates = [
            replace(one, rows=tuple(row for row in one.rows if row in inside)) for one in candidates
        ]
        moved = self._stationarity.update(candidates, tracks, law, self._stamp_ns)
        candidates = [
            replace(one, motions=by_row) for one, by_row in zip(candidates, moved, strict=True)
        ]
        found = hypotheses(law, candidates)
        for one in candidates:
            likely = _probabilities(one.name, found)
            row = max(likely, key=lambda row: likely[row], default=-1)
            label = tracks[row].robot_id if row >= 0 else ""
            known = (self.links.get(one.name), self.recognised.get(one.name))
            least = TUNING.unsure if label in known else TUNING.sure
            if label and likely[row] >= least:
                self.links[one.name] = label
            else:
                self._unlink(one.name)
        self._doubt = self._doubted(tracks, law, candidates, found)
        self.report.update(self._stamp_ns, candidates, found, self.links, law, tracks)

    def _unlink(self, name: str) -> None:
        """Stop using a reference, and forget what it showed."""
        if self.links.pop(name, ""):
            self._memory = None

    def _doubted(
        self,
        tracks: Sequence[NamedTrack],
        law: PositionLaw,
        candidates: list[Candidate],
        found: list[Hypothesis],
    ) -> Array | None:
        """Return by how much (2, 2) all positions are less certain than the chosen law has it, m².

        By the hypotheses not chosen, and by errors of the platform that references show.
        """
        pairs = self._pairs(tracks, True)
        if not pairs:
            return None
        by_name = {one.name: one for one in candidates}
        chosen, drones = law.known(*_known(law, pairs)), range(len(law.receivers) // 2)
        doubts = np.zeros((len(drones), 2, 2))
        for one in found:
            if one.probability < TUNING.negligible:
                break
            other = law
            if one.rows:
                own = [(by_name[name], row) for name, row in one.rows.items()]
                other = law.known(*_known(law, own))
            for drone in drones:
                doubts[drone] += one.probability * _farther(chosen, other, drone)
        misfit = max(
            (by_name[one.name].motion(row).misfit for one, row in pairs if one.name in by_name),
            default=0.0,
        )
        largest: Array = max(doubts, key=np.trace) + misfit * np.eye(2)
        return largest

    def _pairs(self, tracks: Sequence[NamedTrack], now: bool) -> list[tuple[Candidate, int]]:
        """Return used references with the rows of their tracks.

        Args:
            tracks: by row.
            now: whether it is for the time of the last image: those that move are known then.
        """
        rows = {track.robot_id: row for row, track in enumerate(tracks) if track.robot_id}
        pairs: list[tuple[Candidate, int]] = []
        for name, label in self.links.items():
            if label in rows and name in self._candidates and (now or name not in self._moving):
                pairs.append((self._candidates[name], rows[label]))
        return pairs

    def _law(self, rows: list[int]) -> PositionLaw:
        """Return the law of the group of robots that has most of some rows."""
        laws = self._source.laws
        if len(laws) > 1:
            laws = sorted(laws, key=lambda law: -int(np.isin(rows, law.rows).sum()))
        return laws[0]


def _known(law: PositionLaw, pairs: list[tuple[Candidate, int]]) -> tuple[list[int], Array, Array]:
    """Return rows, positions and covariances of references among a law's robots."""
    inside = law.rows.tolist()
    own = [(one, row) for one, row in pairs if row in inside]
    positions, spread = [one.position for one, _ in own], [one.spread for one, _ in own]
    return [row for _, row in own], np.array(positions), np.array(spread)


def _farther(chosen: PositionLaw, other: PositionLaw, drone: int) -> Array:
    """Return by how much (2, 2) another law would widen a drone's receiver's offset, m²."""
    (offset, spread), (mean, unsure) = chosen.offset(drone), other.offset(drone)
    apart = mean - offset
    wider = max(float(np.trace(unsure - spread)), 0.0)
    found: Array = np.outer(apart, apart) + 0.5 * wider * np.eye(2)
    return found


def _uncertainty(law: PositionLaw, without: list[int]) -> float:
    """Return the variances of receivers' offsets and of robots but some rows, summed, m²."""
    variances = law.covariance.diagonal()
    places = law.places([row for row in law.rows.tolist() if row not in without])
    return float(variances[law.receivers].sum() + variances[places].sum())


def _probabilities(name: str, found: list[Hypothesis]) -> dict[int, float]:
    """Return how probable a reference is each track."""
    likely: dict[int, float] = {}
    for one in found:
        if name in one.rows:
            row = one.rows[name]
            likely[row] = likely.get(row, 0.0) + one.probability
    return likely
