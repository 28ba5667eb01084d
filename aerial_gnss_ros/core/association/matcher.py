# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Data association: which box of an image updates which track.

Robots choose first, including tracks whose label is pending; then robots that manoeuvred out of
their gates; tentative tracks choose from what is left.

The matcher only decides; the tracker changes tracks and filter.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.assignment import TUNING as ASSIGNMENT
from aerial_gnss_ros.core.association.clutter import Clutter, chance_probability
from aerial_gnss_ros.core.association.coherence import manoeuvred_pairs, swerves
from aerial_gnss_ros.core.association.decision import NO_PAIRS, Association
from aerial_gnss_ros.core.association.gating import NEITHER, NEW, ROBOT, CandidatePairs
from aerial_gnss_ros.core.association.image_labels import UNMODELLED_COST
from aerial_gnss_ros.core.association.joint_assignment import TUNING as JOINT_ASSIGNMENT
from aerial_gnss_ros.core.association.joint_assignment import jointly_likeliest
from aerial_gnss_ros.core.association.scene_mismatch import RobotsSeen, SceneMismatch
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.filter.joint_filter import JointFilter
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis
from aerial_gnss_ros.core.values.estimates import State

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
ImageCost = Callable[[], Array]
"""Returns minus twice the log likelihood (n, m) of tracks' measurements by tracking in the image;
it is computed where it is needed."""


@dataclass(frozen=True)
class MatcherTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    held_images: int = 3
    """Consecutive images that may miss a robot, however far apart they are. Judged."""


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
        clutter: rates of missed robots and of clutter.
        mismatch: whether images contradict most robots; such images are not used.
    """

    def __init__(self, joint: JointFilter, threshold: float, fresh_s: float) -> None:
        self._filter = joint
        self.threshold = threshold
        self.fresh_s = fresh_s
        self.clutter = Clutter()
        self.mismatch = SceneMismatch()

    def gate(
        self, tracks: list[Track], seen: Measurements, stamp_ns: int, image_cost: ImageCost
    ) -> CandidatePairs | None:
        """Return the candidate pairs of an image, None without tracks or boxes.

        Args:
            tracks: all of them.
            seen: the image's measurements.
            stamp_ns: of the image, ns.
            image_cost: tells what tracking in the image says of tracks and measurements.
        """
        if not tracks or not len(seen.index):
            self.clutter.update(stamp_ns, 0, 0, 0)
            return None
        # Beyond, a pair is neither a near miss nor a manoeuvre.
        kind = self._kinds(tracks, stamp_ns)
        swerve = self.threshold * (MOTION_MODEL.swerve_s * self._filter.motions.largest) ** 2
        pairs = self._filter.compare(seen, ASSIGNMENT.near_gate_radii**2 * self.threshold, swerve)
        distances, classes = mahalanobis(pairs.offsets, pairs.spread), seen.class_ids.tolist()
        self._ignore_wide(kind, pairs.rows.tolist(), distances[1], tracks, stamp_ns)
        found = CandidatePairs.of_image(pairs, distances, kind, tracks, classes, self.threshold)
        return self._judged_jointly(found, seen, image_cost)

    def _judged_jointly(
        self, candidates: CandidatePairs, seen: Measurements, image_cost: ImageCost
    ) -> CandidatePairs:
        """Return the candidates with the assignment of robots that is likeliest for all boxes."""
        if not candidates.contested:
            return candidates
        near, most = candidates.near, JOINT_ASSIGNMENT.most_joint_pairs
        if len(near) > most:
            near = candidates.inside
        if len(near) > most:
            return candidates
        pairs = candidates.pairs.of(near)
        covariance = self._filter.compare_jointly(seen, pairs)
        if covariance is None:
            return candidates
        rows, columns = pairs.rows.tolist(), pairs.columns.tolist()
        # Positions count as well, and links may fail in a way that is not modelled.
        image = np.minimum(image_cost()[pairs.rows, pairs.columns], UNMODELLED_COST)
        chosen = jointly_likeliest(rows, columns, pairs.offsets, covariance, self.threshold, image)
        return candidates.with_given([near[k] for k in chosen])

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
        kind, decided, chosen = candidates.kind, Association(*NO_PAIRS), candidates.given
        left, decided.outside = candidates.left_over
        decided.matched = len(chosen)
        confused = chosen + self._of_another_class(tracks, candidates, stamp_ns)
        shown = self._robots_seen(tracks, candidates, left, confused, boxes)
        passed_s = (stamp_ns - self.clutter.stamp_ns) * 1e-9
        contradicts = self.mismatch.update(self.clutter, shown, passed_s)
        decided.sentence = self.mismatch.sentence
        if contradicts:
            chosen = []
        elif left and (own := self._manoeuvred(tracks, candidates, left)):
            decided.manoeuvred = [candidates.rows[k] for k in own]
            chosen = chosen + own
        decided.claimed = chosen
        if NEW in kind:
            chosen = chosen + _new(candidates, chosen, decided)
        robots = kind.count(ROBOT)
        if not self.mismatch.active:
            missed = robots - len(decided.claimed)
            log_sizes = [candidates.log_determinant[k] for k in candidates.given]
            self.clutter.update(
                stamp_ns, robots, missed, boxes - len(chosen), decided.outside, log_sizes
            )
        decided.rows, decided.columns = (
            candidates.pairs.rows[chosen],
            candidates.pairs.columns[chosen],
        )
        return decided

    def _kinds(self, tracks: list[Track], stamp_ns: int) -> list[str]:
        """Return the kind of each track: robot, new, or neither."""
        found, tentative = list[str](), State.TENTATIVE
        for track in tracks:
            if track.state is tentative and not track.label_pending:
                found.append(NEW)
            elif track.rejected or track.previous_label:
                found.append(NEITHER)
            else:
                fresh = (stamp_ns - track.last_seen_ns) * 1e-9 <= self.fresh_s + 1e-9
                found.append(ROBOT if fresh else NEITHER)
        return found

    def _ignore_wide(
        self, kind: list[str], rows: list[int], log_sizes: Array, tracks: list[Track], stamp_ns: int
    ) -> None:
        """Let robots get no box whose gates have become so wide that it may well be clutter.

        Args:
            kind: of each track, changed in place.
            rows: (k,) of the tracks of pairs.
            log_sizes: (k,) log determinants of their innovations' covariances.
            tracks: all of them.
            stamp_ns: of the image, ns.
        """
        latest_ns = stamp_ns - round(self._missed_s(stamp_ns) * 1e9)
        old = [track.last_seen_ns < latest_ns for track in tracks]
        if not any(old):
            return
        for row, doubtful in zip(rows, self.clutter.doubtful(log_sizes).tolist(), strict=True):
            if doubtful and old[row] and kind[row] is ROBOT:
                kind[row] = NEITHER

    def _of_another_class(
        self, tracks: list[Track], candidates: CandidatePairs, stamp_ns: int
    ) -> list[int]:
        """Return pairs of robots without a box and boxes of another class in their gates.

        They update no robot. But detectors confuse classes, and a robot that was seen a moment ago
        has not left its place to something else, unless that has been seen beside it.
        """
        of, to, near = candidates.rows, candidates.columns, candidates.near
        rows = {of[k] for k in candidates.given}
        if len(rows) == candidates.kind.count(ROBOT):
            return []
        columns, new_at = {to[k] for k in near}, defaultdict[int, list[Track]](list)
        for k in candidates.new_near:
            new_at[to[k]].append(tracks[of[k]])
        latest_ns = stamp_ns - round(self._missed_s(stamp_ns) * 1e9)
        found = [
            k
            for k, (row, column) in enumerate(zip(of, to, strict=True))
            if candidates.kind[row] is ROBOT
            and row not in rows
            and column not in columns
            and candidates.squared[k] <= self.threshold
            and tracks[row].last_seen_ns >= latest_ns
            and not any(new.coexisted(tracks[row]) for new in new_at[column])
        ]
        return candidates.best(found) if found else []

    def _missed_s(self, stamp_ns: int) -> float:
        """Return the time for which the detector may miss a robot in view."""
        return max(
            MOTION_MODEL.held_s, TUNING.held_images * (stamp_ns - self.clutter.stamp_ns) * 1e-9
        )

    def _manoeuvred(
        self, tracks: list[Track], candidates: CandidatePairs, left: list[int]
    ) -> list[int]:
        return manoeuvred_pairs(
            self._filter, tracks, candidates, left, self.threshold, self.clutter
        )

    def _robots_seen(
        self,
        tracks: list[Track],
        candidates: CandidatePairs,
        left: list[int],
        chosen: list[int],
        boxes: int,
    ) -> RobotsSeen:
        """Return what an image shows of the robots; what may have manoeuvred counts as matched.

        So does a robot whose box may have another class.

        Args:
            tracks: all of them.
            candidates: pairs of the image.
            left: left-over pairs of robots and boxes.
            chosen: pairs of updated robots, and of boxes that may be robots of another class.
            boxes: number of boxes of the image.
        """
        in_view: set[int] = set()  # robots at the image's edge may have left it
        for row, kind in enumerate(candidates.kind):
            if kind is ROBOT and not tracks[row].leaving_view:
                in_view.add(row)
        matched = sum(candidates.rows[k] in in_view for k in chosen)
        seen = RobotsSeen(len(in_view), matched, boxes - len(chosen))
        if not seen.contradicts or self.mismatch.active:
            return seen
        outside = [k for k in left if candidates.rows[k] in in_view]
        turned = swerves(self._filter, candidates.pairs, outside, chosen, self.threshold)
        return RobotsSeen(seen.in_view, matched + turned, seen.unclaimed - turned)


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
