# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Data association: which box of an image updates which track.

Robots choose first, including tracks whose label is pending; then robots that manoeuvred out of
their gates; tentative tracks choose from what is left. A robot whose innovations stay larger than
its model explains manoeuvres harder than stated, so its velocity covariance is to be inflated:
otherwise the filter would lag, and the box would leave the gate and start a second track.

The matcher only decides; the tracker changes tracks and filter.
"""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.assignment import TUNING as ASSIGNMENT
from aerial_gnss_ros.core.association.clutter import Clutter, chance_probability
from aerial_gnss_ros.core.association.coherence import manoeuvred_pairs, swerves, turns
from aerial_gnss_ros.core.association.conflicts import keep_established, without_disputed
from aerial_gnss_ros.core.association.decision import NO_PAIRS, Association
from aerial_gnss_ros.core.association.displaced_robots import DisplacedRobots
from aerial_gnss_ros.core.association.gating import NEITHER, NEW, ROBOT, CandidatePairs
from aerial_gnss_ros.core.association.joint_assignment import TUNING as JOINT_ASSIGNMENT
from aerial_gnss_ros.core.association.joint_assignment import jointly_likeliest
from aerial_gnss_ros.core.association.track import TUNING as TRACK
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.filter.joint_filter import JointFilter
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis
from aerial_gnss_ros.core.values.estimates import State

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class MatcherTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    majority_robots: int = 3
    """Number of robots in view from which a majority must agree with an image; of two, one must.
    Judged."""
    held_images: int = 3
    """Consecutive images that may miss a robot, however far apart they are. Judged."""
    strained_mean: float = 3.0
    """Mean normalised squared innovation above which a robot manoeuvres. Without a manoeuvre it is
    exceeded once in a million images (33 of 30 million draws)."""
    common_median: float = 2.0
    """Median of the robots' means above which they have a common cause: latency, or a wrong
    compass. Judged."""
    turn_share: float = 0.25
    """Inflation of a manoeuvring robot's velocity sigma, as a share of `MotionModel.speed_sigma`.
    Judged."""


TUNING = MatcherTuning()


class Matcher:
    """Decides which boxes update which tracks.

    Args:
        joint: the joint filter, read only.
        threshold: squared Mahalanobis distance at the edge of a gate.
        fresh_s: time since a robot was last seen up to which a single box may update it, s.

    Attributes:
        threshold: likewise.
        fresh_s: likewise; longer where images come seldom.
        scene_mismatch: whether an image contradicted most robots, and they have not been reacquired
            since; such images are not used.
    """

    def __init__(self, joint: JointFilter, threshold: float, fresh_s: float) -> None:
        self._filter = joint
        self.threshold = threshold
        self.fresh_s = fresh_s
        self._clutter = Clutter()
        self._displaced = DisplacedRobots()
        self.scene_mismatch = False
        self._reported = False
        self._agreed = 0

    @property
    def cluttered(self) -> bool:
        """Whether robots are missed and boxes are false so often that a new track may be none."""
        return self._clutter.heavy

    def expect_mismatch(self) -> None:
        """Set the scene mismatch that telemetry predicts."""
        self.scene_mismatch, self._agreed = True, 0

    def gate(self, tracks: list[Track], seen: Measurements, stamp_ns: int) -> CandidatePairs | None:
        """Return the candidate pairs of an image, None without tracks or boxes."""
        if not tracks or not len(seen.index):
            self._clutter.update(stamp_ns, 0, 0, 0)
            return None
        # Beyond, a pair is neither a near miss nor a manoeuvre.
        kind = self._kinds(tracks, stamp_ns)
        swerve = self.threshold * (MOTION_MODEL.swerve_s * self._filter.motions.largest) ** 2
        pairs = self._filter.compare(seen, ASSIGNMENT.near_gate_radii**2 * self.threshold, swerve)
        distances, classes = mahalanobis(pairs.offsets, pairs.spread), seen.class_ids.tolist()
        found = CandidatePairs.of_image(pairs, distances, kind, tracks, classes, self.threshold)
        return self._judged_jointly(found, seen)

    def _judged_jointly(self, candidates: CandidatePairs, seen: Measurements) -> CandidatePairs:
        """Return the candidates with the assignment of robots that is likeliest for all boxes."""
        inside = candidates.inside
        if not candidates.contested or len(inside) > JOINT_ASSIGNMENT.most_joint_pairs:
            return candidates
        pairs = candidates.pairs.of(inside)
        covariance = self._filter.compare_jointly(seen, pairs)
        if covariance is None:
            return candidates
        rows, columns = pairs.rows.tolist(), pairs.columns.tolist()
        chosen = jointly_likeliest(rows, columns, pairs.offsets, covariance, self.threshold)
        return candidates.with_given([inside[k] for k in chosen])

    def assign(
        self, tracks: list[Track], candidates: CandidatePairs, boxes: int, stamp_ns: int
    ) -> Association:
        """Assign boxes inside gates to tracks.

        Args:
            tracks: all of them.
            candidates: candidate pairs.
            boxes: number of boxes of the image.
            stamp_ns: of the image, ns.
        """
        # Robots choose first: a false track must not take a robot's boxes.
        inside, kind, decided = candidates.inside, candidates.kind, Association(*NO_PAIRS)
        of, to, given = candidates.rows, candidates.columns, candidates.given
        if len(given) < len(inside):
            away_ns = stamp_ns - round(self._missed_s(stamp_ns) * 1e9)
            given = keep_established(tracks, of, to, given, inside, away_ns)
        same = given is candidates.given
        left, decided.outside = candidates.left_over if same else candidates.left(given)
        chosen, held_ns = given, MOTION_MODEL.held_s * 1e9
        if [k for k in given if stamp_ns - tracks[of[k]].last_seen_ns > held_ns]:
            chosen = without_disputed(
                tracks, of, to, given, candidates.log_likelihood, kind, stamp_ns
            )
        decided.matched = len(chosen)
        if self._is_mismatch(tracks, candidates, left, chosen, boxes, stamp_ns, decided):
            chosen = []
        elif not self._judge_manoeuvres(tracks, candidates, chosen, decided):
            own = self._manoeuvred(tracks, candidates, left) if left else []
            if own:
                rows = candidates.pairs.rows[own]
                decided.inflations.append((rows, self._filter.speeds(rows)))
            chosen = chosen + own
        decided.claimed = chosen
        if NEW in kind:
            chosen = chosen + _new(candidates, chosen, decided)
        robots = kind.count(ROBOT)
        if not self.scene_mismatch:
            missed = robots - len(decided.claimed)
            self._clutter.update(stamp_ns, robots, missed, boxes - len(chosen))
        decided.rows, decided.columns = (
            candidates.pairs.rows[chosen],
            candidates.pairs.columns[chosen],
        )
        return decided

    def _kinds(self, tracks: list[Track], stamp_ns: int) -> list[str]:
        """Return the kind of each track: robot, new, or neither.

        Beyond `MOTION_MODEL.held_s` a robot's gate grows fast, and in clutter a box inside it may
        be false.
        """
        patience_s = self.fresh_s
        if self._clutter.heavy:
            patience_s = min(self._missed_s(stamp_ns), self.fresh_s)
        found, tentative = list[str](), State.TENTATIVE
        for track in tracks:
            if track.state is tentative and not track.label_pending:
                found.append(NEW)
            elif track.rejected or track.previous_label:
                found.append(NEITHER)
            else:
                fresh = (stamp_ns - track.last_seen_ns) * 1e-9 <= patience_s + 1e-9
                found.append(ROBOT if fresh else NEITHER)
        return found

    def _missed_s(self, stamp_ns: int) -> float:
        """Return the time for which the detector may miss a robot in view."""
        return max(
            MOTION_MODEL.held_s, TUNING.held_images * (stamp_ns - self._clutter.stamp_ns) * 1e-9
        )

    def _judge_manoeuvres(
        self,
        tracks: list[Track],
        candidates: CandidatePairs,
        chosen: list[int],
        decided: Association,
    ) -> bool:
        """Decide which robots manoeuvre, by their mean innovations.

        Args:
            tracks: all of them.
            candidates: pairs of the image.
            chosen: those of robots that get a box.
            decided: receives the means and the inflations.

        Returns:
            Whether most do, and a rotation of the camera explains it better than manoeuvres.
        """
        manoeuvring: list[int] = []
        ratios = decided.innovation_ratios
        for k in chosen:
            row, squared = candidates.rows[k], candidates.squared[k]
            ratio = tracks[row].innovation_ratio
            ratios[row] = ratio + (0.5 * squared - ratio) / TRACK.strain_images
            if ratios[row] > TUNING.strained_mean:
                manoeuvring.append(row)
        common = (
            len(ratios) >= TUNING.majority_robots and median(ratios.values()) > TUNING.common_median
        )
        if common and turns(self._filter, tracks, list(ratios)):
            return True
        if manoeuvring:
            ratios.update(dict.fromkeys(manoeuvring, 1.0))
            speeds = TUNING.turn_share * self._filter.speeds(manoeuvring)
            decided.inflations.append((np.array(manoeuvring, np.intp), speeds))
        return False

    def _manoeuvred(
        self, tracks: list[Track], candidates: CandidatePairs, left: list[int]
    ) -> list[int]:
        return manoeuvred_pairs(
            self._filter, tracks, candidates, left, self.threshold, self._clutter.heavy
        )

    def _is_mismatch(
        self,
        tracks: list[Track],
        candidates: CandidatePairs,
        left: list[int],
        chosen: list[int],
        boxes: int,
        stamp_ns: int,
        decided: Association,
    ) -> bool:
        """Return whether an image contradicts most robots, so that none of it is used.

        A rotating compass or a jump displaces robots' boxes onto other robots: the few that fall
        into a gate do so by chance.

        Args:
            tracks: all of them.
            candidates: pairs of the image.
            left: left-over pairs of robots and boxes.
            chosen: pairs of updated robots.
            boxes: number of boxes of the image.
            stamp_ns: of the image, ns.
            decided: receives a sentence for the log.
        """
        in_view: set[int] = set()  # robots at the image's edge may have left it
        for row, kind in enumerate(candidates.kind):
            if kind is ROBOT and not tracks[row].leaving_view:
                in_view.add(row)
        matched = 0
        for k in chosen:
            matched += candidates.rows[k] in in_view
        known = min(len(in_view), boxes - len(chosen) + matched)
        if known > 1 and 2 * matched < known and not self.scene_mismatch:
            outside = [k for k in left if candidates.rows[k] in in_view]
            matched += swerves(self._filter, candidates.pairs, outside, chosen, self.threshold)
        mismatch = known > 1 and 2 * matched < known
        if mismatch and not self.scene_mismatch:
            others = boxes - len(chosen)
            passed_s = (stamp_ns - self._clutter.stamp_ns) * 1e-9
            mismatch = self._displaced.update(
                self._clutter, len(in_view), matched, others, passed_s
            )
        elif matched:
            self._displaced.reset()
        if known < TUNING.majority_robots and not mismatch:
            # Of few robots, all must be reacquired, in more than one image.
            self._agreed = self._agreed + matched if 0 < matched == known else 0
            self.scene_mismatch = self.scene_mismatch and self._agreed < TUNING.majority_robots
            return False
        self._agreed = 0
        if mismatch and self.scene_mismatch and not self._reported:  # one image may be in error
            self._reported = True
            decided.sentence = (
                f"{known - matched} of {known} boxes are not where robots are expected: the "
                "compass, the gimbal or the fix may be wrong; such images update no robot."
            )
        self.scene_mismatch = mismatch
        self._reported &= mismatch
        return mismatch


def _new(candidates: CandidatePairs, chosen: list[int], decided: Association) -> list[int]:
    """Return pairs of new tracks and left-over boxes."""
    taken = {candidates.columns[k] for k in chosen}
    new = candidates.best([k for k in candidates.new_inside if candidates.columns[k] not in taken])
    taken |= {candidates.columns[k] for k in new}
    beside = [k for k in candidates.new_near if candidates.columns[k] not in taken]
    if new:
        share = chance_probability(len(beside), candidates.kind.count(NEW))
        decided.clutter_shares = {candidates.rows[k]: share for k in new}
    decided.near_misses = {candidates.rows[k] for k in beside} - {candidates.rows[k] for k in new}
    return new
