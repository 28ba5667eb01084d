# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which box of an image belongs to which track.

Robots choose first, all at once, those that wait for their names among them; then those that have
swerved; what is left goes to the tentative tracks. A robot whose boxes keep falling further off
than its model explains is turning harder than stated: its velocity is to be inflated. Left alone,
the filter would lag behind, the box would leave the gate and grow a second track on the same robot.

All this is decided and nothing of it done: tracks and filter are the tracker's to change.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from statistics import median

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.assignment import TUNING as ASSIGNMENT
from aerial_gnss_ros.core.association.assignment import lone
from aerial_gnss_ros.core.association.clutter import Clutter, chance_probability
from aerial_gnss_ros.core.association.coherence import swerves, turns
from aerial_gnss_ros.core.association.conflicts import keep_established, without_disputed
from aerial_gnss_ros.core.association.gating import NEITHER, NEW, ROBOT, CandidatePairs
from aerial_gnss_ros.core.association.track import TUNING as TRACK
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.filter.joint_filter import JointFilter
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.models.motion_model import manoeuvre_covariance
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis
from aerial_gnss_ros.core.values.estimates import State

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class MatcherTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    majority_robots: int = 3
    """Robots in view from which on most must agree with an image; of two, one of them. Judged."""
    held_images: int = 3
    """Images in a row that may miss a robot without more ado, however far apart they are.
    Judged."""
    strained_mean: float = 3.0
    """Fading mean of normalised squared innovations from which a robot turns harder than its model.
    One that obeys it gets there once in a million images (33 of 30 million draws of the law)."""
    common_median: float = 2.0
    """Median of the robots' means from which they have a common cause: a latency, a wrong compass.
    Judged."""
    turn_share: float = 0.25
    """Share of `MotionModel.speed_sigma` by which its velocity is then uncertain. Judged."""


TUNING = MatcherTuning()


NO_PAIRS: tuple[Indices, Indices] = np.zeros(0, np.intp), np.zeros(0, np.intp)
"""Rows and columns of nothing."""


@dataclass
class Association:
    """What is decided of an image's boxes; rows are those of tracks.

    Attributes:
        rows: (m,) of the tracks that get a box.
        columns: (m,) of their boxes.
        claimed: which pairs of `CandidatePairs` are robots with their boxes.
        matched: how many robots have a box inside their gates.
        innovation_ratios: new fading means of robots' squared innovations, by row.
        inflations: rows of robots that manoeuvre, and by how much, m/s, their velocities are
            uncertain.
        clutter_shares: factors of `Track.clutter_probability`, by row.
        near_misses: rows of new tracks with boxes just outside their gates.
        outside: how many robots have a box just outside their gates, and none inside.
    """

    rows: Indices
    columns: Indices
    claimed: list[int] = field(default_factory=list)
    innovation_ratios: dict[int, float] = field(default_factory=dict)
    inflations: list[tuple[Indices, Array | float]] = field(default_factory=list)
    clutter_shares: dict[int, float] = field(default_factory=dict)
    near_misses: set[int] = field(default_factory=set)
    matched: int = 0
    outside: int = 0


class Matcher:
    """Decides which boxes belong to which tracks.

    Args:
        joint: where robots are; it is only asked.
        threshold: squared Mahalanobis distance at the edge of a gate.
        fresh_s: time since a robot was seen up to which a single box may update it, s.

    Attributes:
        threshold: likewise.
        fresh_s: likewise; longer where images come seldom.
        scene_mismatch: whether an image was so unlike what was expected that none of it is used,
            and robots have not come back since.
    """

    def __init__(self, joint: JointFilter, threshold: float, fresh_s: float) -> None:
        self._filter = joint
        self.threshold = threshold
        self.fresh_s = fresh_s
        self._clutter = Clutter()
        self.scene_mismatch = False
        self._told = False
        self._agreed = 0

    def expect_mismatch(self) -> None:
        """Take in that robots will not be where they should be, by what telemetry says."""
        self.scene_mismatch, self._agreed = True, 0

    def gate(self, tracks: list[Track], seen: Measurements, stamp_ns: int) -> CandidatePairs | None:
        """Return which boxes may be of which tracks; None where there is nothing to choose."""
        if not tracks or not len(seen.index):
            self._clutter.update(stamp_ns, 0, 0, 0)
            return None
        # Farther off, a pair is neither a near miss nor a robot that has swerved.
        swerve = self.threshold * (MOTION_MODEL.swerve_s * self._filter.motions.largest) ** 2
        pairs = self._filter.compare(seen, ASSIGNMENT.near_gate_radii**2 * self.threshold, swerve)
        kind = self._kinds(tracks, stamp_ns)
        return CandidatePairs.of_image(pairs, kind, tracks, seen.class_ids.tolist(), self.threshold)

    def assign(
        self, tracks: list[Track], able: CandidatePairs, boxes: int, stamp_ns: int
    ) -> Association:
        """Return which of the boxes inside gates belong to which tracks, and what follows.

        Args:
            tracks: all of them.
            able: pairs of tracks and boxes that may belong together.
            boxes: of the image.
            stamp_ns: of the image, ns.
        """
        # Robots choose first: a stray box of a robot must not grow up on that robot's own boxes.
        away_ns = stamp_ns - round(self._missed_s(stamp_ns) * 1e9)
        inside, kind, decided = able.inside, able.kind, Association(*NO_PAIRS)
        given = keep_established(
            tracks, able.rows, able.columns, able.best(inside), inside, away_ns
        )
        chosen = without_disputed(
            tracks, able.rows, able.columns, given, able.log_likelihood, kind, stamp_ns
        )
        left, decided.outside = able.left(given)
        decided.matched = len(chosen)
        if self._is_mismatch(tracks, able, left, chosen, boxes):
            chosen = []
        elif not self._strain(tracks, able, chosen, decided):
            own = self._manoeuvred_pairs(tracks, able, left, decided) if left else []
            chosen = chosen + own
        decided.claimed = chosen
        if NEW in kind:
            chosen = chosen + _new(able, chosen, decided)
        robots = kind.count(ROBOT)
        if not self.scene_mismatch:
            missed = robots - len(decided.claimed)
            self._clutter.update(stamp_ns, robots, missed, boxes - len(chosen))
        decided.rows, decided.columns = able.pairs.rows[chosen], able.pairs.columns[chosen]
        return decided

    def _kinds(self, tracks: list[Track], stamp_ns: int) -> list[str]:
        """Return whether a single box may update each track: as a robot, as a new one, not at all.

        Beyond `MOTION_MODEL.held_s` a robot's gate grows fast. Where images are cluttered the box
        in it may be false.
        """
        patience_s = self.fresh_s
        if self._clutter.heavy:
            patience_s = min(self._missed_s(stamp_ns), self.fresh_s)
        found: list[str] = []
        for track in tracks:
            if track.state is State.TENTATIVE and not track.label_pending:
                found.append(NEW)
            elif track.rejected or track.previous_label:
                found.append(NEITHER)
            else:
                fresh = (stamp_ns - track.last_seen_ns) * 1e-9 <= patience_s + 1e-9
                found.append(ROBOT if fresh else NEITHER)
        return found

    def _missed_s(self, stamp_ns: int) -> float:
        """Return for how long images may miss a robot that is in view."""
        return max(
            MOTION_MODEL.held_s, TUNING.held_images * (stamp_ns - self._clutter.stamp_ns) * 1e-9
        )

    def _strain(
        self, tracks: list[Track], able: CandidatePairs, chosen: list[int], decided: Association
    ) -> bool:
        """Decide which robots' boxes are off by more than their model explains.

        Args:
            tracks: all of them.
            able: pairs of the image.
            chosen: those of robots that get a box.
            decided: gets the means, and the velocities to be inflated.

        Returns:
            Whether most are, and one turn of the camera explains it better than robots that turn.
        """
        turning: list[int] = []
        strain = decided.innovation_ratios
        for k in chosen:
            row, squared = able.rows[k], able.squared[k]
            ratio = tracks[row].innovation_ratio
            strain[row] = ratio + (0.5 * squared - ratio) / TRACK.strain_images
            if strain[row] > TUNING.strained_mean:
                turning.append(row)
        strained = (
            len(strain) >= TUNING.majority_robots and median(strain.values()) > TUNING.common_median
        )
        if strained and turns(self._filter, tracks, list(strain)):
            return True
        if turning:
            strain.update(dict.fromkeys(turning, 1.0))
            speeds = TUNING.turn_share * self._filter.speeds(turning)
            decided.inflations.append((np.array(turning, np.intp), speeds))
        return False

    def _manoeuvred_pairs(
        self, tracks: list[Track], able: CandidatePairs, left: list[int], decided: Association
    ) -> list[int]:
        """Return pairs of robots and boxes left over that can only belong together.

        A robot that is not where it should be, and a box beside it that is nobody else's: it has
        swerved, rather than vanished just when another one came up there. But an image may have
        missed it, and shown a false box there: the lower the camera, the more of the image is
        beside a robot. Where images are such, the box must go on where an earlier one was since
        the robot was seen.

        Args:
            tracks: all of them.
            able: pairs of the image, without a swerve.
            left: those of robots and boxes that are left over, of one class.
            decided: gets the velocities to be inflated.
        """
        pairs = able.pairs
        more = manoeuvre_covariance(self._filter.speeds(pairs.rows[left]))
        squared, _ = mahalanobis(pairs.offsets[left], pairs.spread[left] + more)
        near = [k for k, one in zip(left, squared.tolist(), strict=True) if one <= self.threshold]
        rows, columns = pairs.rows[near].tolist(), pairs.columns[near].tolist()
        own: list[int] = []
        for k, row, column, alone in zip(near, rows, columns, lone(rows, columns), strict=True):
            others = [tracks[able.rows[i]] for i in able.new_inside if able.columns[i] == column]
            if not alone or any(tracks[row].coexisted(other) for other in others):
                continue
            if not self._clutter.heavy or any(_began(other, tracks[row]) for other in others):
                own.append(k)
        if own:
            decided.inflations.append((pairs.rows[own], self._filter.speeds(pairs.rows[own])))
        return own

    def _is_mismatch(
        self,
        tracks: list[Track],
        able: CandidatePairs,
        left: list[int],
        chosen: list[int],
        boxes: int,
    ) -> bool:
        """Return whether an image is so unlike what was expected that none of it is believed.

        A spinning compass or a jump carries robots' boxes onto other robots: the few that fall
        into a gate are there by chance.

        Args:
            tracks: all of them.
            able: pairs of the image.
            left: those of robots and boxes that are left over.
            chosen: those of robots that get a box.
            boxes: of the image.
        """
        here: set[int] = set()  # one that was at the picture's edge has left it
        for row, kind in enumerate(able.kind):
            if kind is ROBOT and not tracks[row].leaving_view:
                here.add(row)
        matched = 0
        for k in chosen:
            matched += able.rows[k] in here
        known = min(len(here), boxes - len(chosen) + matched)
        if known > 1 and 2 * matched < known and not self.scene_mismatch:
            stray = [k for k in left if able.rows[k] in here]
            matched += swerves(self._filter, able.pairs, stray, chosen, self.threshold)
        confused = known > 1 and 2 * matched < known
        if known < TUNING.majority_robots and not confused:
            # Few robots are back when all of them are, and not once by chance.
            self._agreed = self._agreed + matched if 0 < matched == known else 0
            self.scene_mismatch = self.scene_mismatch and self._agreed < TUNING.majority_robots
            return False
        self._agreed = 0
        if confused and self.scene_mismatch and not self._told:  # one image may be in error
            self._told = True
            self._filter.log.add(
                f"{known - matched} of {known} boxes are not where robots should be: the compass, "
                "the gimbal or the fix may be wrong; robots are not updated by such images."
            )
        self.scene_mismatch = confused
        self._told &= confused
        return confused


def _new(able: CandidatePairs, chosen: list[int], decided: Association) -> list[int]:
    """Return pairs of new tracks and boxes that are left; the more such boxes, the more chance."""
    taken = {able.columns[k] for k in chosen}
    new = able.best([k for k in able.new_inside if able.columns[k] not in taken])
    taken |= {able.columns[k] for k in new}
    beside = [k for k in able.new_near if able.columns[k] not in taken]
    if new:
        share = chance_probability(len(beside), able.kind.count(NEW))
        decided.clutter_shares = {able.rows[k]: share for k in new}
    decided.near_misses = {able.rows[k] for k in beside} - {able.rows[k] for k in new}
    return new


def _began(other: Track, robot: Track) -> bool:
    """Return whether a track began when a robot was seen no more."""
    return other.first_seen_ns > robot.last_seen_ns
