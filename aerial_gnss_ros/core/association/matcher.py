# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which box of an image belongs to which track.

Robots choose first, all at once, those that wait for their names among them; then those that have
swerved; what is left goes to the tentative tracks. A robot whose boxes keep falling further off
than its model explains is turning harder than stated: its velocity is loosened. Left alone, the
filter would lag behind, the box would leave the gate and grow a second track on the same robot.
"""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.assignment import TUNING as ASSIGNMENT
from aerial_gnss_ros.core.association.assignment import Pairs, lone
from aerial_gnss_ros.core.association.clutter import Clutter, chance_probability
from aerial_gnss_ros.core.association.coherence import swerves, turns
from aerial_gnss_ros.core.association.conflicts import keep_established, without_disputed
from aerial_gnss_ros.core.association.gating import NEITHER, NEW, ROBOT, CandidatePairs
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.faults.noise_level import Innovation
from aerial_gnss_ros.core.filter.innovation import PairInnovations
from aerial_gnss_ros.core.filter.joint_filter import JointFilter
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.models.motion_model import manoeuvre_covariance
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis
from aerial_gnss_ros.core.values.estimates import State

Array = NDArray[np.float64]


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


class Matcher:
    """Assigns boxes to tracks.

    Args:
        joint: where robots are.
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

    def match(self, tracks: list[Track], seen: Measurements, stamp_ns: int) -> Pairs:
        """Return rows of tracks and columns of measurements that belong together."""
        if not tracks or not len(seen.index):
            self._clutter.update(stamp_ns, 0, 0, 0)
            return np.zeros(0, np.intp), np.zeros(0, np.intp)
        # Farther off, a pair is neither a near miss nor a robot that has swerved.
        swerve = self.threshold * (MOTION_MODEL.swerve_s * self._filter.motions.largest) ** 2
        pairs = self._filter.compare(seen, ASSIGNMENT.near_gate_radii**2 * self.threshold, swerve)
        kind = [self._kind(track, stamp_ns) for track in tracks]
        classes, ids = [track.class_id for track in tracks], seen.class_ids.tolist()
        able = CandidatePairs.of_image(pairs, kind, classes, ids, self.threshold)

        # Robots choose first: a stray box of a robot must not grow up on that robot's own boxes.
        away_ns = stamp_ns - round(self._missed_s(stamp_ns) * 1e9)
        self._note_noise(tracks, pairs, able, stamp_ns)
        inside = able.inside
        given = keep_established(tracks, able.of, able.to, able.best(inside), inside, away_ns)
        chosen = without_disputed(tracks, able.of, able.to, given, able.log, kind, stamp_ns)
        left = able.left(given)
        missed = {able.of[k] for k in able.near(left)}
        self._filter.monitor.update_matches(len(chosen), len(missed))
        # One that was at the picture's edge has left it.
        here = [one is ROBOT and not tracks[row].leaving for row, one in enumerate(kind)]
        back = sum(here[able.of[k]] for k in chosen)
        boxes = len(seen.index) - len(chosen) + back
        known = min(sum(here), boxes)
        if known > 1 and 2 * back < known and not self.scene_mismatch:
            stray = [k for k in left if here[able.of[k]]]
            back += swerves(self._filter, pairs, stray, chosen, self.threshold)
        if self._is_mismatch(sum(here), boxes, back):
            chosen = []
        elif not self._inflate_manoeuvring(tracks, [(able.of[k], able.squared[k]) for k in chosen]):
            chosen = chosen + self._manoeuvred_pairs(tracks, pairs, left, able.grown)
        self._filter.update_reacquired(
            pairs.rows[chosen], pairs.offsets[chosen], pairs.spread[chosen]
        )
        claimed = len(chosen)
        chosen = chosen + _new(tracks, able, chosen)
        robots = kind.count(ROBOT)
        if not self.scene_mismatch:
            self._clutter.update(stamp_ns, robots, robots - claimed, len(seen.index) - len(chosen))
        return pairs.rows[chosen], pairs.columns[chosen]

    def _note_noise(
        self, tracks: list[Track], pairs: PairInnovations, able: CandidatePairs, stamp_ns: int
    ) -> None:
        """Take in how far the boxes of robots in view are from where they are expected."""
        seen: list[tuple[Innovation, ...]] = []
        share = 1.0 / self._filter.noise.level
        rows: set[int] = set()
        columns: set[int] = set()
        for k in sorted(able.near(able.robots), key=able.squared.__getitem__):
            row, column = able.of[k], able.to[k]
            if row in rows or column in columns:
                continue
            rows.add(row)
            columns.add(column)
            (east, north), ((a, b), (_, d)) = pairs.offsets[k].tolist(), pairs.spread[k].tolist()
            one = Innovation(stamp_ns, east, north, (share * a, share * b, share * d))
            tracks[row].innovations = (*tracks[row].innovations[-2:], one)
            seen.append(tracks[row].innovations)
        self._filter.noise.update(seen)

    def _kind(self, track: Track, stamp_ns: int) -> str:
        """Return whether a single box may update a track: as a robot, as a new one, not at all."""
        if track.state is State.TENTATIVE and not track.waits:
            return NEW
        if track.rejected or track.once:
            return NEITHER
        fresh = (stamp_ns - track.last_seen_ns) * 1e-9 <= self._patience_s(stamp_ns) + 1e-9
        return ROBOT if fresh else NEITHER

    def _patience_s(self, stamp_ns: int) -> float:
        """Return the time since a robot was seen up to which a single box may update it.

        Beyond `MOTION_MODEL.held_s` its gate grows fast. Where images are cluttered the box in it
        may be false.
        """
        if not self._clutter.heavy:
            return self.fresh_s
        return min(self._missed_s(stamp_ns), self.fresh_s)

    def _missed_s(self, stamp_ns: int) -> float:
        """Return for how long images may miss a robot that is in view."""
        return max(
            MOTION_MODEL.held_s, TUNING.held_images * (stamp_ns - self._clutter.stamp_ns) * 1e-9
        )

    def _inflate_manoeuvring(self, tracks: list[Track], hits: list[tuple[int, float]]) -> bool:
        """Loosen the robots whose boxes are off by more than their model explains.

        Args:
            tracks: all of them.
            hits: rows of those with a box, and its squared distance.

        Returns:
            Whether most are, and one turn of the camera explains it better than robots that turn.
        """
        strain = {row: tracks[row].stress(squared) for row, squared in hits}
        strained = (
            len(strain) >= TUNING.majority_robots and median(strain.values()) > TUNING.common_median
        )
        if strained and turns(self._filter, tracks, list(strain)):
            return True
        turning = [row for row, mean in strain.items() if mean > TUNING.strained_mean]
        for row in turning:
            tracks[row].strain = 1.0
        if turning:
            speeds = TUNING.turn_share * self._filter.speeds(turning)
            self._filter.inflate_velocities(
                np.array(turning, np.intp), speeds, MOTION_MODEL.swerve_s
            )
        return False

    def _manoeuvred_pairs(
        self, tracks: list[Track], pairs: PairInnovations, left: list[int], grown: list[int]
    ) -> list[int]:
        """Return pairs of robots and boxes left over that can only belong together.

        A robot that is not where it should be, and a box beside it that is nobody else's: it has
        swerved, rather than vanished just when another one came up there. But an image may have
        missed it, and shown a false box there: the lower the camera, the more of the image is
        beside a robot. Where images are such, the box must go on where an earlier one was since
        the robot was seen.

        Args:
            tracks: all of them.
            pairs: without a swerve.
            left: those of robots and boxes that are left over, of one class.
            grown: those of tentative tracks with boxes inside their gates.
        """
        if not left:
            return []
        more = manoeuvre_covariance(self._filter.speeds(pairs.rows[left]))
        squared, _ = mahalanobis(pairs.offsets[left], pairs.spread[left] + more)
        near = [k for k, one in zip(left, squared.tolist(), strict=True) if one <= self.threshold]
        rows, columns = pairs.rows[near].tolist(), pairs.columns[near].tolist()
        own: list[int] = []
        for k, row, column, alone in zip(near, rows, columns, lone(rows, columns), strict=True):
            others = [tracks[pairs.rows[i]] for i in grown if pairs.columns[i] == column]
            if not alone or any(tracks[row].coexisted(other) for other in others):
                continue
            if not self._clutter.heavy or any(_began(other, tracks[row]) for other in others):
                own.append(k)
        self._filter.inflate_velocities(
            pairs.rows[own], self._filter.speeds(pairs.rows[own]), MOTION_MODEL.swerve_s
        )
        return own

    def _is_mismatch(self, robots: int, boxes: int, matched: int) -> bool:
        """Return whether an image is so unlike what was expected that none of it is believed.

        A spinning compass or a jump carries robots' boxes onto other robots: the few that fall
        into a gate are there by chance.
        """
        known = min(robots, boxes)
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


def _new(tracks: list[Track], able: CandidatePairs, chosen: list[int]) -> list[int]:
    """Return pairs of new tracks and boxes that are left; the more such boxes, the more chance."""
    if NEW not in able.kind:
        return []
    taken = {able.to[k] for k in chosen}
    new = able.best([k for k in able.grown if able.to[k] not in taken])
    taken |= {able.to[k] for k in new}
    near = [k for k in able.near(able.alike) if able.kind[able.of[k]] is NEW]
    beside = [k for k in near if able.to[k] not in taken]
    if new:
        share = chance_probability(len(beside), able.kind.count(NEW))
        for k in new:
            tracks[able.of[k]].chance *= share
    found = {able.of[k] for k in new}
    for row in {able.of[k] for k in beside} - found:
        tracks[row].near_misses += 1
    return new


def _began(other: Track, robot: Track) -> bool:
    """Return whether a track began when a robot was seen no more."""
    return other.first_seen_ns > robot.last_seen_ns
