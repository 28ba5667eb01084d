# SPDX-License-Identifier: Apache-2.0
"""Constant-velocity Kalman filter on the water, for many robots at once, with a considered bias.

State of a robot: east, north (m), velocity east, north (m/s) in the frame `map`. The velocity is a
random walk (white acceleration of density q² in m²/s³), so both matrices of the discrete model are
exact for any step (Bar-Shalom, Li, Kirubarajan 2001, 6.2.2).

What a measurement says is not the robot's place but z = p + L b + w: w is white, while b, the
platform's slow errors in units of their own sigma, is about the same for minutes. The filter does
not estimate b. It carries, beside the covariance P of what white noise does to its state, the
sensitivity M = d(state error)/db through every prediction and gain it used («consider» analysis,
Schmidt 1966; Jazwinski 1970, 8.4). So P + M Mᵀ is the covariance of the state's error whatever the
gain was, and it never falls below what the platform is wrong by, however many images are averaged.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SLOW_COUNT = 6
"""Most slow errors that a measurement may name; narrower Jacobians are filled with zeros."""


@dataclass(frozen=True)
class Beliefs:
    """What is known of n robots.

    Attributes:
        mean: (n, 4) east, north, velocity east, velocity north; m, m/s.
        covariance: (n, 4, 4) share of white noise and of the robot's own motion.
        sensitivity: (n, 4, k) state error per one sigma of each slow platform error.
    """

    mean: Array
    covariance: Array
    sensitivity: Array

    def __len__(self) -> int:
        return len(self.mean)

    def __getitem__(self, index: object) -> Beliefs:
        """Return the robots that a mask or an index array (never a single integer) names."""
        rows = np.asarray(index)
        return Beliefs(self.mean[rows], self.covariance[rows], self.sensitivity[rows])

    @property
    def total_covariance(self) -> Array:
        """(n, 4, 4) covariance of the error, the platform's share included."""
        return self.covariance + outer(self.sensitivity)


def outer(factor: Array) -> Array:
    """Return factor @ factorᵀ over leading axes."""
    product: Array = factor @ np.swapaxes(factor, -1, -2)
    return product


def nothing() -> Beliefs:
    """Return the belief about no robot."""
    return Beliefs(np.zeros((0, 4)), np.zeros((0, 4, 4)), np.zeros((0, 4, SLOW_COUNT)))


def join(first: Beliefs, second: Beliefs) -> Beliefs:
    """Return the robots of both, in order."""
    return Beliefs(
        np.concatenate([first.mean, second.mean]),
        np.concatenate([first.covariance, second.covariance]),
        np.concatenate([first.sensitivity, second.sensitivity]),
    )


def replace_rows(beliefs: Beliefs, rows: NDArray[np.intp], new: Beliefs) -> Beliefs:
    """Return the beliefs with some rows exchanged."""
    mean, covariance = beliefs.mean.copy(), beliefs.covariance.copy()
    sensitivity = beliefs.sensitivity.copy()
    mean[rows], covariance[rows], sensitivity[rows] = new.mean, new.covariance, new.sensitivity
    return Beliefs(mean, covariance, sensitivity)


def begin(positions: Array, white: Array, slow: Array, speed_sigma: float) -> Beliefs:
    """Return beliefs from one measurement each.

    Args:
        positions: (n, 2) measured east, north, m.
        white: (n, 2, 2) white covariance, m².
        slow: (n, 2, k) metres per one sigma of each slow platform error.
        speed_sigma: one sigma of the unknown velocity, each axis, m/s.
    """
    count = len(positions)
    mean, covariance = np.zeros((count, 4)), np.zeros((count, 4, 4))
    sensitivity = np.zeros((count, 4, slow.shape[-1]))
    mean[:, :2], covariance[:, :2, :2], sensitivity[:, :2] = positions, white, slow
    covariance[:, 2, 2] = covariance[:, 3, 3] = speed_sigma**2
    return Beliefs(mean, covariance, sensitivity)


def transition(seconds: float) -> Array:
    """Return the (4, 4) matrix that moves a state on by a time step."""
    matrix = np.eye(4)
    matrix[0, 2] = matrix[1, 3] = seconds
    return matrix


def process_noise(seconds: float, acceleration: float) -> Array:
    """Return the exact (4, 4) covariance that white acceleration adds in a time step.

    Args:
        seconds: length of the step, s.
        acceleration: root of the spectral density, m/s^1.5.
    """
    t, density = seconds, acceleration**2
    noise = np.zeros((4, 4))
    noise[0, 0] = noise[1, 1] = density * t**3 / 3.0
    noise[2, 2] = noise[3, 3] = density * t
    noise[0, 2] = noise[2, 0] = noise[1, 3] = noise[3, 1] = density * t**2 / 2.0
    return noise


def predict(beliefs: Beliefs, seconds: float, acceleration: float) -> Beliefs:
    """Return the beliefs a time step later; steps compose, so their lengths do not matter."""
    if seconds == 0.0 or not len(beliefs):
        return beliefs
    step = transition(seconds)
    covariance = step @ beliefs.covariance @ step.T + process_noise(seconds, acceleration)
    return Beliefs(beliefs.mean @ step.T, covariance, step @ beliefs.sensitivity)


def wander(beliefs: Beliefs, seconds: float, speed_sigma: float, memory_s: float) -> Beliefs:
    """Return the beliefs about robots that nobody sees, a time step later.

    Such a robot may turn or stop: its velocity forgets itself and goes over into one of zero mean
    and `speed_sigma` (an Ornstein-Uhlenbeck process, discretised exactly; Bar-Shalom, Li,
    Kirubarajan 2001, 8.2.3 with velocity in place of acceleration). Steps compose.

    Args:
        beliefs: n robots.
        seconds: length of the step, s.
        speed_sigma: one sigma of the velocity in the long run, each axis, m/s.
        memory_s: time after which a velocity counts for 1/e, s.
    """
    if seconds == 0.0 or not len(beliefs):
        return beliefs
    left, gone = np.exp(-seconds / memory_s), -np.expm1(-seconds / memory_s)
    step, noise = np.eye(4), np.zeros((4, 4))
    variance, t = speed_sigma**2, seconds / memory_s
    for p, v in ((0, 2), (1, 3)):
        step[p, v], step[v, v] = memory_s * gone, left
        noise[p, p] = variance * memory_s**2 * (2.0 * t - 2.0 * gone - gone**2)
        noise[p, v] = noise[v, p] = variance * memory_s * gone**2
        noise[v, v] = variance * (1.0 - left**2)
    covariance = step @ beliefs.covariance @ step.T + noise
    return Beliefs(beliefs.mean @ step.T, covariance, step @ beliefs.sensitivity)


def correct(beliefs: Beliefs, positions: Array, white: Array, slow: Array, drift: Array) -> Beliefs:
    """Return the beliefs after one measurement of each robot.

    The gain also allows for the change of the platform's share since the state was formed: slow
    less the state's own sensitivity. The covariance is carried in Joseph's form, which holds for
    any gain.

    Args:
        beliefs: n robots, predicted to the time of the measurement.
        positions: (n, 2) measured east, north, m.
        white: (n, 2, 2) white covariance, m².
        slow: (n, 2, k) metres per one sigma of each slow platform error.
        drift: (n, 2, 2) covariance by which the slow errors' share moved since the last
            measurement, m²; see `slow_drift`.
    """
    moved = beliefs.covariance.copy()
    moved[:, :2, :2] += drift
    apparent = moved.copy()
    apparent[:, :2, :2] += outer(slow - beliefs.sensitivity[:, :2])
    innovation = apparent[:, :2, :2] + white
    gain = np.swapaxes(np.linalg.solve(innovation, apparent[:, :2, :]), -1, -2)
    keep = np.broadcast_to(np.eye(4), moved.shape).copy()
    keep[:, :, :2] -= gain
    residual = positions - beliefs.mean[:, :2]
    mean = beliefs.mean + (gain @ residual[:, :, None])[:, :, 0]
    covariance = keep @ moved @ np.swapaxes(keep, -1, -2)
    covariance = covariance + gain @ white @ np.swapaxes(gain, -1, -2)
    covariance = 0.5 * (covariance + np.swapaxes(covariance, -1, -2))
    return Beliefs(mean, covariance, keep @ beliefs.sensitivity + gain @ slow)


def slow_drift(beliefs: Beliefs, seconds: Array, correlation_time_s: float) -> Array:
    """Return (n, 2, 2): how far the slow errors' share has wandered since the last measurement.

    A first-order Gauss-Markov error of unit variance has moved by a variance of
    1 - exp(-2 t / correlation time) that its old value does not tell.

    Args:
        beliefs: n robots.
        seconds: (n,) time since each was last measured, s.
        correlation_time_s: of the slow errors; 0 means that they are white.
    """
    if correlation_time_s <= 0.0:
        share = np.ones(len(beliefs))
    else:
        share = -np.expm1(-2.0 * np.asarray(seconds) / correlation_time_s)
    return share[:, None, None] * outer(beliefs.sensitivity[:, :2])
