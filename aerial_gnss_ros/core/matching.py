# SPDX-License-Identifier: Apache-2.0
"""Which box of an image belongs to which track.

Robots choose first, all at once, those that wait for their names among them; then those that have
swerved; what is left goes to the tentative tracks. A robot whose boxes keep falling further off
than its model explains is turning harder than stated: its velocity is loosened. Left alone, the
filter would lag behind, the box would leave the gate and grow a second track on the same robot.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association import (
    Pairs,
    assign,
    lone_pairs,
    mahalanobis,
    near_misses,
)
from aerial_gnss_ros.core.joint import JointFilter
from aerial_gnss_ros.core.measurements import Measurements
from aerial_gnss_ros.core.track import Track
from aerial_gnss_ros.core.values import State

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

LEAST_KNOWN = 3
"""Robots in view from which on most must agree with an image."""

SWERVE_S = 0.5
"""How long ago a robot may have changed its velocity without anyone noticing, s."""

STRAINED = 3.0
"""Mean normalised squared innovation from which a robot turns harder than its model: 1 in 20,000
for eight good images."""

COMMON = 2.0
"""Median of the robots' means from which they have a common cause: a latency, a wrong compass."""

TURN_SHARE = 0.25
"""Share of `Motion.speed_sigma` by which its velocity is then uncertain."""


class Matcher:
    """Assigns boxes to tracks.

    Args:
        joint: where robots are.
        threshold: squared Mahalanobis distance at the edge of a gate.
        fresh_s: time since a robot was seen up to which a single box may update it, s.

    Attributes:
        confused: whether the last image was so unlike what was expected that none of it is used.
    """

    def __init__(self, joint: JointFilter, threshold: float, fresh_s: float) -> None:
        self._filter = joint
        self._threshold = threshold
        self._fresh_s = fresh_s
        self.confused = False

    def match(self, tracks: list[Track], seen: Measurements, stamp_ns: int) -> Pairs:
        """Return rows of tracks and columns of measurements that belong together."""
        if not tracks or not len(seen.index):
            return np.zeros(0, np.intp), np.zeros(0, np.intp)
        offsets, spread = self._filter.compare(seen)
        squared, log_determinant = mahalanobis(offsets, spread)
        classes = np.array([track.class_id for track in tracks], dtype=str)
        alike = classes[:, None] == seen.class_ids[None]
        allowed = (squared <= self._threshold) & alike
        unseen = np.array([(stamp_ns - track.last_seen_ns) * 1e-9 for track in tracks])
        fresh = unseen <= self._fresh_s + 1e-9
        tentative = np.array(
            [track.state is State.TENTATIVE and not track.waits for track in tracks], dtype=bool
        )
        robots = (fresh & ~tentative)[:, None]
        # Robots choose first: a stray box of a robot must not grow up on that robot's own boxes.
        rows, columns = assign(squared, log_determinant, allowed & robots, self._threshold)
        rows = kept(tracks, rows, columns, allowed & robots)
        missed = near_misses(
            np.where(alike & robots, squared, np.inf), rows, columns, self._threshold
        )
        self._filter.monitor.take_matches(len(rows), missed)
        if self._is_confused(int(robots.sum()), len(seen.index), len(rows)):
            rows = columns = np.zeros(0, np.intp)
        elif not self._watch_strain(tracks, rows, squared[rows, columns]):
            far = alike & robots
            far[rows], far[:, columns] = False, False
            grown = allowed & tentative[:, None]
            more_rows, more_columns = self._swerved(tracks, offsets, spread, far, grown)
            rows = np.concatenate([rows, more_rows])
            columns = np.concatenate([columns, more_columns])
        allowed[:, columns] = False
        more_rows, more_columns = assign(
            squared, log_determinant, allowed & tentative[:, None], self._threshold
        )
        return np.concatenate([rows, more_rows]), np.concatenate([columns, more_columns])

    def _watch_strain(self, tracks: list[Track], rows: Indices, squared: Array) -> bool:
        """Loosen the robots whose boxes are off by more than their model explains.

        Returns:
            Whether most are: then it is the platform, and no robot turns.
        """
        strain = [tracks[row].stress(float(d)) for row, d in zip(rows, squared, strict=True)]
        if len(strain) >= LEAST_KNOWN and float(np.median(strain)) > COMMON:
            return True
        turning = rows[np.array(strain) > STRAINED]
        for row in turning:
            tracks[row].strain = 1.0
        speed = TURN_SHARE * self._filter.motion.speed_sigma
        self._filter.loosen(turning, speed, SWERVE_S)
        return False

    def _swerved(
        self,
        tracks: list[Track],
        offsets: Array,
        spread: Array,
        free: NDArray[np.bool_],
        grown: NDArray[np.bool_],
    ) -> Pairs:
        """Return robots and boxes left over that can only belong together.

        A robot that is not where it should be, and a box beside it that is nobody else's: it has
        swerved, rather than vanished just when another one came up there.

        Args:
            tracks: all n of them.
            offsets: (n, m, 2) from robots to boxes, m.
            spread: (n, m, 2, 2) their covariances without a swerve, m².
            free: (n, m) pairs of robots and boxes that are left over, of one class.
            grown: (n, m) tentative tracks with boxes inside their gates.
        """
        if not free.any():
            return np.zeros(0, np.intp), np.zeros(0, np.intp)
        speed = self._filter.motion.speed_sigma
        squared, _ = mahalanobis(offsets, spread + swerved(speed))
        rows, columns = lone_pairs(free & (squared <= self._threshold))
        own = np.ones(len(rows), dtype=bool)
        for i, (row, column) in enumerate(zip(rows, columns, strict=True)):
            others = [tracks[other] for other in np.flatnonzero(grown[:, column])]
            own[i] = not any(tracks[row].seen_beside(other) for other in others)
        rows, columns = rows[own], columns[own]
        self._filter.loosen(rows, speed, SWERVE_S)
        return rows, columns

    def _is_confused(self, robots: int, boxes: int, matched: int) -> bool:
        """Return whether an image is so unlike what was expected that none of it is believed.

        A spinning compass or a jump carries robots' boxes onto other robots: the few that fall
        into a gate are there by chance.
        """
        known = min(robots, boxes)
        if known < LEAST_KNOWN:
            return False
        confused = 2 * matched < known
        if confused and not self.confused:
            self._filter.log.add(
                f"Of {known} boxes only {matched} are where robots should be: the compass, the "
                "gimbal or the fix may be wrong; robots are not updated by such images."
            )
        self.confused = confused
        return confused


def swerved(speed: float) -> Array:
    """Return by how much a swerve that nobody has noticed moves a robot, covariance (2, 2), m².

    Args:
        speed: one sigma of the change of velocity, each axis, m/s.
    """
    return (SWERVE_S * speed) ** 2 * np.eye(2)


def kept(
    tracks: list[Track], rows: Indices, columns: Indices, allowed: NDArray[np.bool_]
) -> Indices:
    """Return the rows of an assignment, each box left to the robot that has been wearing it.

    Two robots of which one image after the other shows only one may be one robot with two tracks.
    Whichever is nearer by chance must not take the box: the name would alternate. It stays with the
    one seen last; the other coasts, until an image shows both or it comes up for itself.

    Args:
        tracks: n of them.
        rows: k that the assignment gave a box.
        columns: theirs.
        allowed: (n, m) robots and boxes inside their gates.
    """
    wearing = rows.copy()
    for i, (row, column) in enumerate(zip(rows, columns, strict=True)):
        track = tracks[row]
        wearers = [
            other
            for other in np.flatnonzero(allowed[:, column])
            if other not in wearing
            and tracks[other].last_seen_ns > track.last_seen_ns
            and not tracks[other].seen_beside(track)
        ]
        if wearers:
            wearing[i] = max(wearers, key=lambda other: tracks[other].last_seen_ns)
    return wearing
