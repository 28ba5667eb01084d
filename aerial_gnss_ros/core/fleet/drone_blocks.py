# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Joint Gaussian of several drones' errors and of robots, with one drone's part as a `JointState`.

An image of one drone depends on that drone's errors and on robots alone. These form a `JointState`,
the *active* part. The errors of all other drones are kept beside it, with their covariances with
the active part.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.state import JointState, inverse_of_errors
from aerial_gnss_ros.core.fleet.receivers import joint_prior
from aerial_gnss_ros.core.models.platform_model import COUNT, GNSS, LATENCY

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class DroneBlocks:
    """Which drone is active, and what is known of all.

    Args:
        stationary: (9, 9) prior covariance of each drone's errors.
        share: prior share of the receivers' variance that is common to all drones.

    Attributes:
        joint: the active drone's errors and the robots.
        active: number of the active drone.
    """

    def __init__(self, stationary: list[Array], share: float) -> None:
        self.joint = JointState(stationary[0])
        self.active, self._others = 0, list(range(1, len(stationary)))
        self._share = share
        size = COUNT * len(self._others)
        self._mean = np.zeros(size)
        self._cross = np.zeros((COUNT, size))  # of the active part with the others
        self._own = np.zeros((size, size))
        active, between, own = self._prior(stationary)
        self._cross[:], self._own[:] = between, own
        self.joint.covariance[:] = active

    def platform(self, drone: int) -> tuple[Array, Array]:
        """Return a drone's errors (9,) and their covariance (9, 9)."""
        if drone == self.active:
            return self.joint.mean[:COUNT].copy(), self.joint.covariance[:COUNT, :COUNT].copy()
        own = self._place(drone)
        return self._mean[own].copy(), self._own[own, own].copy()

    def assume(self, drone: int, errors: Array) -> None:
        """Set a drone's errors (9,) at the beginning, for derivatives near the truth."""
        self.activate(drone)
        self.joint.mean[:COUNT] = errors

    def platforms(self) -> tuple[Array, Array]:
        """Return all drones' errors (9 N,) and their covariance, in the drones' order."""
        mean, every = np.concatenate([self.joint.mean[:COUNT], self._mean]), self._in_order()
        return mean[every], self._errors()[np.ix_(every, every)]

    def ordered(self) -> tuple[Array, Array]:
        """Return mean and covariance of everything: all drones' errors in their order, robots."""
        joint, every = self.joint, self._in_order()
        errors, P = self.platforms()
        with_robots = np.concatenate([joint.covariance[COUNT:, :COUNT], self._cross[COUNT:]], 1)
        robots = joint.covariance[COUNT:, COUNT:]
        mean = np.concatenate([errors, joint.mean[COUNT:]])
        return mean, _symmetric(P, with_robots[:, every].T, robots)

    def _errors(self) -> Array:
        """Return the covariance of the active drone's errors and those of the others (9 N, 9 N)."""
        return _symmetric(self.joint.covariance[:COUNT, :COUNT], self._cross[:COUNT], self._own)

    def _in_order(self) -> Indices:
        """Return where in (active drone, other drones) each error (9 N,) is, by drones' order."""
        places = np.argsort([self.active, *self._others])
        every: Indices = (COUNT * places[:, None] + np.arange(COUNT)).ravel()
        return every

    def prior(self, stationary: list[Array]) -> Array:
        """Return the prior covariance of all drones' errors (9 N, 9 N), in the drones' order.

        Args:
            stationary: (9, 9) of each drone.
        """
        return joint_prior(stationary, self._share)

    def whole(self) -> tuple[Array, Array, list[int]]:
        """Return mean and covariance of everything, and the order of the drones' blocks in it.

        The active drone's errors come first, then the robots, then the other drones.
        """
        mean = np.concatenate([self.joint.mean, self._mean])
        P = _symmetric(self.joint.covariance, self._cross, self._own)
        return mean, P, [self.active, *self._others]

    def activate(self, drone: int) -> None:
        """Make another drone's errors part of the active `JointState`."""
        if drone == self.active:
            return
        own, joint, active = self._place(drone), self.joint, slice(COUNT)
        joint.mean, self._mean = joint.mean.copy(), self._mean.copy()
        P, cross, others = joint.covariance, self._cross, self._own
        by_drone, by_active = cross[:, own].copy(), P[:, active].copy()
        between, of_drone = by_drone[active].copy(), others[own, own].copy()
        with_drone = others[own].copy()
        joint.mean[active], self._mean[own] = self._mean[own].copy(), joint.mean[active].copy()
        others[own], others[:, own] = cross[active], cross[active].T
        others[own, own] = by_active[active]
        cross[active], cross[:, own] = with_drone, by_active
        cross[active, own] = between.T
        P[:, active], P[active] = by_drone, by_drone.T
        P[active, active] = of_drone
        self._others[self._others.index(drone)] = self.active
        self.active = drone
        joint.view = None

    def doubt_platforms(self, stationary: list[Array]) -> None:
        """Take back what manoeuvres taught of all drones' errors; see `JointState.doubt_platform`.

        All at once, by their joint prior: drone by drone, what one was taught would come back to it
        by the others, and an error could become less certain than it is before any image.

        Args:
            stationary: (9, 9) prior covariance of each drone's errors.
        """
        joint = self.joint
        factor = joint.manoeuvre_noise.take_underestimated()
        if factor <= 1.0:
            return
        if not self._others:
            joint.doubt_platform(factor, stationary[self.active])
            return
        prior = joint_prior([stationary[k] for k in (self.active, *self._others)], self._share)
        errors, mean = self._errors(), np.concatenate([joint.mean[:COUNT], self._mean])
        moved, wider = discounted(mean, errors, prior, factor)
        with_errors = np.concatenate([joint.covariance[COUNT:, :COUNT], self._cross[COUNT:]], 1)
        through = np.concatenate(
            [np.eye(COUNT, len(mean)), with_errors @ inverse_of_errors(errors)]
        )
        by_errors = through @ wider
        joint.mean = joint.mean + through @ moved
        joint.covariance = joint.covariance + by_errors @ through.T
        self._mean = self._mean + moved[COUNT:]
        self._cross = self._cross + by_errors[:, COUNT:]
        self._own = self._own + wider[COUNT:, COUNT:]

    def linearise_at(self, drone: int, positions: Array) -> None:
        """Make a drone active and set the estimate, for derivatives at the truth of its image.

        Args:
            drone: its number.
            positions: (n, 2) true East, North by `joint.rows`, m; errors are 0.
        """
        self.activate(drone)
        joint = self.joint
        joint.mean[:], self._mean[:] = 0.0, 0.0
        joint.robots[:, :2] = positions[joint.rows]
        joint.camera[:], joint.view = np.nan, None  # nothing is carried

    def apart(self, first: int, second: int, sigma: float) -> float:
        """Return the squared Mahalanobis distance of two robots; see `tie`."""
        joint, k = self.joint, COUNT + 4 * np.array([first, second])
        offset = joint.mean[k[0] : k[0] + 2] - joint.mean[k[1] : k[1] + 2]
        rows = joint.covariance[k[0] : k[0] + 2] - joint.covariance[k[1] : k[1] + 2]
        spread = rows[:, k[0] : k[0] + 2] - rows[:, k[1] : k[1] + 2] + sigma**2 * np.eye(2)
        return float(offset @ np.linalg.solve(spread, offset))

    def tie(self, first: int, second: int, sigma: float) -> None:
        """Condition on two robots having the same position; see `JointState.tie`."""
        joint = self.joint
        a, b = COUNT + 4 * first, COUNT + 4 * second
        apart = joint.covariance[a : a + 2] - joint.covariance[b : b + 2]
        by_others = self._cross[a : a + 2] - self._cross[b : b + 2]
        spread = apart[:, a : a + 2] - apart[:, b : b + 2] + sigma**2 * np.eye(2)
        offset = joint.mean[a : a + 2] - joint.mean[b : b + 2]
        joint.tie(first, second, sigma)
        root = np.linalg.cholesky(spread)
        by_active = np.linalg.solve(root, apart)
        by_others = np.linalg.solve(root, by_others)
        self._mean -= np.linalg.solve(root, offset) @ by_others
        self._cross -= by_active.T @ by_others
        self._own -= by_others.T @ by_others

    def forget_gnss(self, drone: int, stationary: list[Array]) -> None:
        """Reset a receiver's offset, which has jumped, to what the other receivers tell of it.

        Args:
            drone: its number.
            stationary: (9, 9) prior covariance of each drone's errors.
        """
        self.activate(drone)
        active, between, own = self._prior(stationary)
        joint, others = self.joint, np.arange(len(self._mean)) % COUNT < GNSS.stop
        rest = own[np.ix_(others, others)]
        by_others = between[GNSS][:, others] @ np.linalg.pinv(rest, hermitian=True)
        joint.mean[GNSS] = by_others @ self._mean[others]
        with_joint = by_others @ self._cross[:, others].T
        with_others = by_others @ self._own[others]
        joint.covariance[GNSS], joint.covariance[:, GNSS] = with_joint, with_joint.T
        unknown = active[GNSS, GNSS] - by_others @ rest @ by_others.T
        told = by_others @ self._own[np.ix_(others, others)] @ by_others.T
        joint.covariance[GNSS, GNSS] = unknown + told
        self._cross[GNSS] = with_others

    def _pass_on(self, by_active: Array, by_others: Array, white: Array) -> None:
        """Update the other drones after an update of the active part.

        Args:
            by_active: (m, d) covariance of the whitened innovation with the active part.
            by_others: (m, k) the same with the other drones' errors.
            white: (m,) innovation in its own units, by which the active part was corrected.
        """
        # The latency is only considered by `update.correct`.
        self.joint.mean[LATENCY] += white @ by_active[:, LATENCY]
        self._mean += white @ by_others
        self._cross -= by_active.T @ by_others
        self._own -= by_others.T @ by_others

    def _place(self, drone: int) -> slice:
        """Return where the errors of a drone that is not active are among the others'."""
        k = COUNT * self._others.index(drone)
        return slice(k, k + COUNT)

    def _prior(self, stationary: list[Array]) -> tuple[Array, Array, Array]:
        """Return the prior covariance of the active drone, with the others, and of these."""
        order = [stationary[drone] for drone in (self.active, *self._others)]
        whole = joint_prior(order, self._share)
        return whole[:COUNT, :COUNT], whole[:COUNT, COUNT:], whole[COUNT:, COUNT:]


def discounted(mean: Array, covariance: Array, prior: Array, factor: float) -> tuple[Array, Array]:
    """Return by what errors change if all that was measured of them counts less.

    Of the information what is not the prior's is divided by the factor (see `JointState.discount`):
    P' = (P⁻¹ / f + (1 - 1 / f) P0⁻¹)⁻¹, written without an inverse of what may be singular.

    Args:
        mean: (d,) of the errors.
        covariance: (d, d) P.
        prior: (d, d) P0; the mean before any data is 0.
        factor: f, above 1.

    Returns:
        (d,) change of the mean, and (d, d) of the covariance.
    """
    scale = np.sqrt(prior.diagonal())
    known = np.flatnonzero(scale)
    each, scales = np.ix_(known, known), np.outer(scale[known], scale[known])
    P, P0 = covariance[each] / scales, prior[each] / scales
    # Receivers that have all in common have a singular prior: hence the small variance.
    spread = P + P0 / (factor - 1.0) + 1e-9 * np.eye(len(known))
    less = np.linalg.solve(spread, P)
    moved, wider = np.zeros_like(mean), np.zeros_like(covariance)
    moved[known] = -scale[known] * (less.T @ (mean[known] / scale[known]))
    found = (factor - 1.0) * P - factor * P @ less
    wider[each] = 0.5 * (found + found.T) * scales
    return moved, wider


def _symmetric(first: Array, between: Array, second: Array) -> Array:
    """Return a covariance (n + k, n + k) from its blocks (n, n), (n, k) and (k, k)."""
    n, k = between.shape
    whole = np.empty((n + k, n + k))
    whole[:n, :n], whole[:n, n:] = first, between
    whole[n:, :n], whole[n:, n:] = between.T, second
    return whole
