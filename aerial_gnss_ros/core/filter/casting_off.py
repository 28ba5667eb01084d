# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether robots that a law takes to be moored have cast off: an interacting multiple model.

Each moored robot has several modes. In the first one the law is right, and its innovations are
white. In the others the robot has left: it is d from where the law shows it, and goes away with a
velocity v. Innovations then have the mean B d, B the derivative of its pixel by its place (the
signature of a change: Willsky and Jones 1976), which the law partly takes for noise: after each
image d is less by what the law's own place has followed.

A robot casts off at a constant rate, and the modes' odds follow from their likelihoods. When it did
is unknown: the moments of a mode are matched with those of one that begins anew (d = 0, v unknown;
Blom and Bar-Shalom 1988). By the modes' probabilities alone, what is unlikely would forget at once
what speaks for it, so that nothing slow could ever add up. Modes therefore keep at least what their
memory says: a short one for what leaves fast, a long one for what leaves slowly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.numerics.gaussian import inverse, mahalanobis

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CastingOffTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    rate_hz: float = 1.0 / 100.0
    """How often a moored robot casts off, 1/s: in a flight of minutes each may. With once in five
    minutes, sigma of one that stays has 3 mm less, and of the positions of one that leaves, in its
    first five seconds, a third more are beyond chi-square 13.8 (3.5 for 2.5 %)."""
    speeds_mps: tuple[float, ...] = (0.3, 0.05)
    """Speeds with which it does, one sigma, each axis, m/s. Judged."""
    memories_s: tuple[float, ...] = (1.0, 6.0)
    """For how long the modes of these speeds remember what speaks for them while they are unlikely,
    s. Judged."""


TUNING = CastingOffTuning()

_ANEW = np.square(TUNING.speeds_mps)[:, None, None] * np.diag([0.0, 0.0, 1.0, 1.0])
_MEMORIES = np.array(TUNING.memories_s)
_MODES = len(_MEMORIES)
_PLACE, _SPEED = np.arange(2), np.arange(2, 4)


class CastingOff:
    """Of the n robots of a law.

    Args:
        count: n.

    Attributes:
        log_odds: (n, k) of the modes in which robots have left, to the one in which they have not,
            nats; -inf: not asked for.
        mean: (n, k, 4) how far they are then from where the law shows them, and their velocity
            relative to what the law says, m, m/s.
        covariance: (n, k, 4, 4) of that.
    """

    def __init__(self, count: int) -> None:
        self.log_odds: Array = np.full((count, _MODES), -np.inf)
        self.mean: Array = np.zeros((count, _MODES, 4))
        self.covariance: Array = np.tile(_ANEW, (count, 1, 1, 1))

    @property
    def odds(self) -> Array:
        """(n,) log odds that robots have left, nats."""
        found: Array = np.logaddexp.reduce(self.log_odds, axis=1)
        return found

    def keep(self, kept: NDArray[np.bool_], more: int) -> None:
        """Forget robots and add some of which it is not asked for.

        Args:
            kept: (n,) mask.
            more: how many are added.
        """
        new = CastingOff(more)
        self.log_odds = np.concatenate([self.log_odds[kept], new.log_odds])
        self.mean = np.concatenate([self.mean[kept], new.mean])
        self.covariance = np.concatenate([self.covariance[kept], new.covariance])

    def begin(self, slot: int, odds: float) -> None:
        """Ask for a robot; `odds`: log odds that it is not moored, nats."""
        self.log_odds[slot] = odds - math.log(_MODES)
        self.mean[slot], self.covariance[slot] = 0.0, _ANEW

    def end(self, slot: int) -> None:
        """Ask for a robot no longer."""
        self.log_odds[slot] = -np.inf

    def predict(self, seconds: float, density: float) -> None:
        """Move on in time.

        Args:
            seconds: length of the step, s.
            density: of white acceleration of robots that swim, m²/s³.
        """
        asked = np.flatnonzero(self.log_odds[:, 0] > -np.inf)
        # Those that stay become fewer by exp(-grown).
        grown = min(TUNING.rate_hz * seconds, 50.0)
        before = self.log_odds[asked] + grown
        after = np.logaddexp(before, math.log(math.expm1(grown) / _MODES))
        self.log_odds[asked] = after
        old = np.maximum(np.exp(before - after), np.exp(-seconds / _MEMORIES))[..., None]
        mean, P = self.mean[asked], self.covariance[asked]
        spread = (old * (1.0 - old) * mean)[..., None] * mean[..., None, :]
        P = old[..., None] * P + (1.0 - old)[..., None] * _ANEW + spread
        mean = old * mean
        mean[..., :2] += seconds * mean[..., 2:]
        P[..., :2, :] += seconds * P[..., 2:, :]
        P[..., :2] += seconds * P[..., 2:]
        P[..., _PLACE, _PLACE] += density * seconds**3 / 3.0
        P[..., _PLACE, _SPEED] += 0.5 * density * seconds**2
        P[..., _SPEED, _PLACE] += 0.5 * density * seconds**2
        P[..., _SPEED, _SPEED] += density * seconds
        self.mean[asked], self.covariance[asked] = mean, P

    def update(
        self, slots: Indices, residual: Array, spread: Array, by_place: Array, followed: Array
    ) -> float:
        """Take in an image; return how much likelier it is than where none leaves, nats.

        Args:
            slots: (m,) robots that are asked for.
            residual: (m, 2) of their boxes in the law, given all other boxes, px.
            spread: (m, 2, 2) covariance of that, px².
            by_place: (m, 2, 2) derivative of their pixels by their places, px/m.
            followed: (m, 2, 2) share of a displacement that the law has followed.
        """
        mean, P = self.mean[slots], self.covariance[slots]
        by_place, followed = by_place[:, None], followed[:, None]
        shown = P[..., :2] @ by_place.swapaxes(2, 3)
        whole = spread[:, None] + by_place @ shown[..., :2, :]
        off = residual[:, None] - (by_place @ mean[..., :2, None])[..., 0]
        moored, size = mahalanobis(residual, spread)
        left, larger = mahalanobis(off, whole)
        before = self.log_odds[slots]
        after = before + 0.5 * ((moored + size)[:, None] - left - larger)
        self.log_odds[slots] = after
        gain = shown @ inverse(whole)
        mean = mean + (gain @ off[..., None])[..., 0]
        P = P - gain @ shown.swapaxes(2, 3)
        mean[..., :2] -= (followed @ mean[..., :2, None])[..., 0]
        P[..., :2, :] -= followed @ P[..., :2, :]
        P[..., :2] -= P[..., :2] @ followed.swapaxes(2, 3)
        self.mean[slots], self.covariance[slots] = mean, 0.5 * (P + P.swapaxes(2, 3))
        return float((_of_all(after) - _of_all(before)).sum())

    def gone(self, slot: int) -> tuple[Array, Array]:
        """Return the moments (4,) and (4, 4) of a robot in the modes in which it has left."""
        shares = np.exp(self.log_odds[[slot]] - self.odds[slot])
        mean, covariance = _moments(shares, self.mean[[slot]], self.covariance[[slot]])
        return mean[0], covariance[0]

    def mix(self, slots: Indices, states: Array, covariances: Array) -> tuple[Array, Array]:
        """Return the moments of all modes.

        Args:
            slots: (m,) of robots.
            states: (m, 4) positions and velocities where none has left, m, m/s.
            covariances: (m, 4, 4) of these.
        """
        logs = self.log_odds[slots]
        shares = np.exp(logs - _of_all(logs)[:, None])
        mean, covariance = _moments(shares, self.mean[slots], self.covariance[slots])
        return states + mean, covariances + covariance


def _of_all(log_odds: Array) -> Array:
    """Return log odds (m,) of all modes, also of the one in which robots have not left."""
    return np.asarray(np.logaddexp(0.0, np.logaddexp.reduce(log_odds, axis=1)))


def _moments(shares: Array, means: Array, covariances: Array) -> tuple[Array, Array]:
    """Return the moments of mixtures (m, k) of which what is missing to 1 is exactly zero."""
    mean = (shares[..., None] * means).sum(axis=1)
    second = covariances + means[..., None] * means[..., None, :]
    whole = (shares[..., None, None] * second).sum(axis=1)
    covariance: Array = whole - mean[..., None] * mean[..., None, :]
    return mean, covariance
