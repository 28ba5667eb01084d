# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where a robot out of sight may be, and how it swims there: what a new track is compared with.

A mixture of four. The robot stays where it went down; it wanders about there as fast as it swam in
sight; it goes straight on; or it does anything that the filter allows, which sets the gate and is
published. Which one it was shows in how it swims when it is back, too: one that went straight on
still has about the velocity that it had, the more so the nearer it is to where that leads.

Only ratios of likelihoods count. So that of a new track's velocity is given by that of a robot of
which nothing is known, and as long as the velocity has not been seen it says nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ReturnPositionTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    part_share: float = 0.25
    """Of each of the four parts of the mixture. Judged."""
    stays_mps: float = 0.08
    """Speed of a robot that stays where it went down, each axis, m/s. Judged."""
    course_share: float = 0.3
    """A robot that goes straight on is off by such a share of its way, one sigma; of the way at the
    speed that it is used to, where it was slower just then. Judged."""
    smallest_variance_m2: float = 1e-3
    """Least variance of a place, m². Judged."""
    moment_s: float = 1e-3
    """A robot unseen for so long is no longer held on its course as one that was seen just now, s.
    Judged."""
    unseen_variance_m2ps2: float = 1e4
    """Variance of a velocity that has not been seen, m²/s². Judged."""


TUNING = ReturnPositionTuning()


@dataclass(frozen=True)
class VelocityLikelihood:
    """How m new tracks swim, by their boxes alone.

    Attributes:
        velocities: (m, 2) East, North, m/s.
        spread: (m, 2, 2) covariance, m²/s²; very large where it has not been seen.
    """

    velocities: Array
    spread: Array

    @classmethod
    def of(cls, velocities: Array, spread: Array, speed: Array | float) -> VelocityLikelihood:
        """Return what estimates say beyond what they began with.

        Args:
            velocities: (m, 2) estimates, which began with none, m/s.
            spread: (m, 2, 2) their covariances, m²/s².
            speed: (m,) with which they began, one sigma, each axis, m/s.
        """
        values, axes = np.linalg.eigh(spread)
        began = np.square(np.asarray(speed))[..., None]
        told = np.maximum(1.0 - values / began, values / TUNING.unseen_variance_m2ps2)
        alone = np.einsum("mij,mj,mkj->mik", axes, 1.0 / told, axes)
        own = np.einsum("mij,mj,mkj->mik", axes, values / told, axes)
        return cls(np.einsum("mij,mj->mi", alone, velocities), own)

    def ratio(self, expected: Array, spread: Array, speed: float) -> Array:
        """Return how much likelier (…, m) they are than of a robot of which nothing is known.

        Args:
            expected: (…, m, 2) velocities, m/s.
            spread: (…, m, 2, 2) covariances, m²/s².
            speed: of a robot of which nothing is known, one sigma, each axis, m/s.
        """
        log = _log_normal(self.velocities - expected, self.spread + spread)
        return np.exp(log - _log_normal(self.velocities, self.spread + speed**2 * np.eye(2)))


class ReturnPosition:
    """Says how likely robots out of sight are where something came up, swimming as it does.

    Args:
        motion: of robots out of sight, as the filter has it.
    """

    def __init__(self, motion: MotionModel) -> None:
        self._motion = motion

    def new_robot_density(
        self, tracks: list[Track], offsets: Array, side: float, swims: VelocityLikelihood
    ) -> Array:
        """Return the density (m,) of places of a robot never seen, times the ratio of velocities.

        Robots of one mission are near one another, and swim alike. So half of the law is that of
        the view, and half a normal law about the middle of the n that are known, with the spread
        that they have; one robot spread as the view is counted with them, as long as they are few.

        Args:
            tracks: n robots that are known.
            offsets: (n, m, 2) from these to the new tracks, m.
            side: of the water in view, m.
            swims: how the new tracks swim.
        """
        speed, n = self._motion.speed_sigma, len(tracks)
        middle = offsets.mean(axis=0)
        apart = offsets[:, 0] - middle[0]
        spread = (side**2 / 12.0 * np.eye(2) + apart.T @ apart) / n
        near = _normal(middle, np.tile(spread, (len(middle), 1, 1)))
        squares = sum(one.speed_history for one in tracks)
        usual = (speed**2 + squares) / (1.0 + sum(one.speed_history_count for one in tracks))
        alike = swims.ratio(np.zeros(2), usual * np.eye(2), speed)
        return 0.5 * (side**-2 + near) * alike

    def density(
        self, track: Track, unseen: float, offsets: Array, spread: Array, swims: VelocityLikelihood
    ) -> Array:
        """Return the density (m,) of places, 1/m², times the ratio of velocities.

        Args:
            track: the robot out of sight.
            unseen: for how long, s.
            offsets: (m, 2) from where the filter has it, m.
            spread: (m, 2, 2) covariances of these, m².
            swims: how the new tracks swim.
        """
        motion, eye = self._motion, np.eye(2)
        unseen = max(unseen, TUNING.moment_s)
        reach, _, noise = motion.step(unseen, np.full(1, TUNING.moment_s))
        arm, grown = float(reach[0]), float(noise[0, 0])
        habit = track.typical_speed(motion.speed_sigma)
        slow = min(TUNING.stays_mps, motion.speed_sigma)
        back = offsets + arm * track.velocity
        usual = swims.ratio(np.zeros(2), habit**2 * eye, motion.speed_sigma)
        further = (unseen**2 - arm**2) * track.velocity_spread
        straight = self._straight(
            track, unseen, offsets - (unseen - arm) * track.velocity,
            _less(spread, grown) + further, swims,
        )  # fmt: skip
        return TUNING.part_share * (
            usual * _normal(back, _less(spread, grown - self._wander(unseen, slow)))
            + usual * _normal(offsets, _less(spread, grown - self._wander(unseen, habit)))
            + straight
            + _normal(offsets, spread)
        )

    def _straight(
        self, track: Track, unseen: float, ahead: Array, spread: Array, swims: VelocityLikelihood
    ) -> Array:
        """Return the same of a robot that goes straight on.

        It is pushed off its course by white noise: errors of place and velocity go together. By
        the stated acceleration, too, its velocity is forgotten, within a minute or so.

        Args:
            track: the robot out of sight.
            unseen: for how long, s.
            ahead: (m, 2) offsets from where it should be, m.
            spread: (m, 2, 2) covariances of these, but for what it is off its course, m².
            swims: how the new tracks swim.
        """
        speed = max(float(np.hypot(*track.velocity)), track.typical_speed(self._motion.speed_sigma))
        off, eye = (TUNING.course_share * speed * unseen) ** 2, np.eye(2)
        known, stated = track.velocity_spread, self._motion.acceleration**2 * unseen
        place = spread + off * eye
        with_it = 1.5 * off / unseen * eye + unseen * known
        gain = with_it @ np.linalg.inv(place)
        turned = (3.0 * off / unseen**2 + stated) * eye + known - gain @ with_it
        expected = track.velocity + np.einsum("mij,mj->mi", gain, ahead)
        return _normal(ahead, place) * swims.ratio(expected, turned, self._motion.speed_sigma)

    def _wander(self, unseen: float, speed: float) -> float:
        """Return the variance of a place after a time of wandering at a speed, each axis, m²."""
        motion = MotionModel(min(self._motion.acceleration, speed), speed)
        return float(motion.step(unseen, np.full(1, TUNING.moment_s))[2][0, 0])


def _less(spread: Array, variance: float) -> Array:
    """Return covariances (m, 2, 2) less a variance in every direction, still positive."""
    a, b, d = spread[:, 0, 0], spread[:, 0, 1], spread[:, 1, 1]
    least = 0.5 * (a + d) - np.hypot(0.5 * (a - d), b)
    taken: Array = np.minimum(variance, least - TUNING.smallest_variance_m2)
    return spread - taken[:, None, None] * np.eye(2)


def _normal(offsets: Array, spread: Array) -> Array:
    """Return the density of planar normal laws."""
    return np.exp(_log_normal(offsets, spread))


def _log_normal(offsets: Array, spread: Array) -> Array:
    """Return the log density of planar normal laws."""
    squared, log_determinant = mahalanobis(offsets, spread)
    log: Array = -0.5 * (squared + log_determinant) - np.log(2.0 * np.pi)
    return log
