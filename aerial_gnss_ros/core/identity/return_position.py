# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Position and velocity density of a robot out of view, with which new tracks are compared.

A mixture of four equally weighted models: the robot stays where it dived; it wanders about there at
its usual speed; it continues straight on; or it does whatever the filter's motion model allows,
which sets the gate and the published covariance. Velocity at the return distinguishes them, too: a
robot that continued straight on still has about its old velocity, the more so the closer it is to
the extrapolated position.

Velocity likelihoods are ratios to an uninformative prior: while a velocity is not observed yet, the
ratio is one.
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

    stays_mps: float = 0.08
    """Speed of a robot that stays where it dived, each axis, m/s. Judged."""
    course_share: float = 0.3
    """Position error of a robot that continues straight on, one sigma, as a share of the distance
    covered at its present or, if that is greater, its usual speed. Judged."""
    smallest_variance_m2: float = 1e-3
    """Least variance of a position, m². Judged."""
    moment_s: float = 1e-3
    """Time unseen after which a robot is no longer held on its course, s. Judged."""
    unseen_variance_m2ps2: float = 1e4
    """Variance of a velocity that has not been observed, m²/s². Judged."""


TUNING = ReturnPositionTuning()


@dataclass(frozen=True)
class VelocityLikelihood:
    """Velocities of m new tracks, from their boxes alone.

    Attributes:
        velocities: (m, 2) East, North, m/s.
        spread: (m, 2, 2) covariance, m²/s²; very large where not observed.
    """

    velocities: Array
    spread: Array

    @classmethod
    def of(cls, velocities: Array, spread: Array, speed: Array | float) -> VelocityLikelihood:
        """Return what estimates add to their prior.

        Args:
            velocities: (m, 2) estimates, with a prior mean of zero, m/s.
            spread: (m, 2, 2) their covariances, m²/s².
            speed: (m,) prior sigma, each axis, m/s.
        """
        values, axes = np.linalg.eigh(spread)
        began = np.square(np.asarray(speed))[..., None]
        weight = np.maximum(1.0 - values / began, values / TUNING.unseen_variance_m2ps2)
        alone = np.einsum("mij,mj,mkj->mik", axes, 1.0 / weight, axes)
        own = np.einsum("mij,mj,mkj->mik", axes, values / weight, axes)
        return cls(np.einsum("mij,mj->mi", alone, velocities), own)

    def ratio(self, expected: Array, spread: Array, speed: float) -> Array:
        """Return likelihood ratios (…, m) of velocities to the uninformative prior.

        Args:
            expected: (…, m, 2) velocities, m/s.
            spread: (…, m, 2, 2) covariances, m²/s².
            speed: prior sigma of an unknown velocity, each axis, m/s.
        """
        log = _log_normal(self.velocities - expected, self.spread + spread)
        return np.exp(log - _log_normal(self.velocities, self.spread + speed**2 * np.eye(2)))


class ReturnPosition:
    """Densities of robots out of view at the positions and velocities of new tracks.

    Args:
        motion: motion model of robots out of view.
    """

    def __init__(self, motion: MotionModel) -> None:
        self._motion = motion

    def new_robot_density(
        self, tracks: list[Track], offsets: Array, side: float, velocities: VelocityLikelihood
    ) -> Array:
        """Return the position density (m,) of a new robot, 1/m², times its velocity ratio.

        Robots of one mission stay together and move alike. So the density is half uniform over the
        view and half Gaussian around the known robots with their spread, to which one virtual robot
        spread over the view is added.

        Args:
            tracks: n known robots.
            offsets: (n, m, 2) from known robots to new tracks, m.
            side: side length of the water in view, m.
            velocities: velocity likelihoods of the new tracks.
        """
        speed, n = self._motion.speed_sigma, len(tracks)
        middle = offsets.mean(axis=0)
        apart = offsets[:, 0] - middle[0]
        spread = (side**2 / 12.0 * np.eye(2) + apart.T @ apart) / n
        near = _normal(middle, np.tile(spread, (len(middle), 1, 1)))
        squares = sum(one.speed_history for one in tracks)
        usual = (speed**2 + squares) / (1.0 + sum(one.speed_history_count for one in tracks))
        velocity_ratio = velocities.ratio(np.zeros(2), usual * np.eye(2), speed)
        return 0.5 * (side**-2 + near) * velocity_ratio

    def density(
        self,
        track: Track,
        unseen: float,
        offsets: Array,
        spread: Array,
        velocities: VelocityLikelihood,
    ) -> Array:
        """Return the position density (m,) of a robot, 1/m², times its velocity ratio.

        Args:
            track: the robot out of view.
            unseen: time since it was last seen, s.
            offsets: (m, 2) from the filter's prediction, m.
            spread: (m, 2, 2) covariances of these, m².
            velocities: velocity likelihoods of the new tracks.
        """
        motion, eye = self._motion, np.eye(2)
        unseen = max(unseen, TUNING.moment_s)
        reach, _, noise = motion.step(unseen, np.full(1, TUNING.moment_s))
        arm, grown = float(reach[0]), float(noise[0, 0])
        usual_speed = track.typical_speed(motion.speed_sigma)
        slow = min(TUNING.stays_mps, motion.speed_sigma)
        held = offsets + arm * track.velocity
        usual = velocities.ratio(np.zeros(2), usual_speed**2 * eye, motion.speed_sigma)
        further = (unseen**2 - arm**2) * track.velocity_spread
        straight = self._straight(
            track, unseen, offsets - (unseen - arm) * track.velocity,
            _reduced(spread, grown) + further, velocities,
        )  # fmt: skip
        return 0.25 * (
            usual * _normal(held, _reduced(spread, grown - self._wander(unseen, slow)))
            + usual * _normal(offsets, _reduced(spread, grown - self._wander(unseen, usual_speed)))
            + straight
            + _normal(offsets, spread)
        )

    def _straight(
        self,
        track: Track,
        unseen: float,
        ahead: Array,
        spread: Array,
        velocities: VelocityLikelihood,
    ) -> Array:
        """Return the same for a robot that continues straight on.

        White noise deflects it, so that errors of position and velocity are correlated. The stated
        acceleration makes it lose its velocity within a minute or so.

        Args:
            track: the robot out of view.
            unseen: time since it was last seen, s.
            ahead: (m, 2) offsets from the position straight ahead, m.
            spread: (m, 2, 2) their covariances without the deflection, m².
            velocities: velocity likelihoods of the new tracks.
        """
        speed = max(float(np.hypot(*track.velocity)), track.typical_speed(self._motion.speed_sigma))
        off, eye = (TUNING.course_share * speed * unseen) ** 2, np.eye(2)
        known, stated = track.velocity_spread, self._motion.acceleration**2 * unseen
        place = spread + off * eye
        with_it = 1.5 * off / unseen * eye + unseen * known
        gain = with_it @ np.linalg.inv(place)
        turned = (3.0 * off / unseen**2 + stated) * eye + known - gain @ with_it
        expected = track.velocity + np.einsum("mij,mj->mi", gain, ahead)
        return _normal(ahead, place) * velocities.ratio(expected, turned, self._motion.speed_sigma)

    def _wander(self, unseen: float, speed: float) -> float:
        """Return the position variance of wandering at a speed, each axis, m²."""
        motion = MotionModel(min(self._motion.acceleration, speed), speed)
        return float(motion.step(unseen, np.full(1, TUNING.moment_s))[2][0, 0])


def _reduced(spread: Array, variance: float) -> Array:
    """Return covariances (m, 2, 2) less an isotropic variance, kept positive definite."""
    a, b, d = spread[:, 0, 0], spread[:, 0, 1], spread[:, 1, 1]
    least = 0.5 * (a + d) - np.hypot(0.5 * (a - d), b)
    taken: Array = np.minimum(variance, least - TUNING.smallest_variance_m2)
    return spread - taken[:, None, None] * np.eye(2)


def _normal(offsets: Array, spread: Array) -> Array:
    """Return planar Gaussian densities."""
    return np.exp(_log_normal(offsets, spread))


def _log_normal(offsets: Array, spread: Array) -> Array:
    """Return planar Gaussian log densities."""
    squared, log_determinant = mahalanobis(offsets, spread)
    log: Array = -0.5 * (squared + log_determinant) - np.log(2.0 * np.pi)
    return log
