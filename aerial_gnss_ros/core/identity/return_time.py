# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How long robots stay out of sight, learnt from those that came back.

Robots of one mission dive alike: one that has been away for as long as others were is likelier to
be the one that comes up than one that has just gone down. Nothing is supposed of it at first. Each
robot that came back, weighted by how surely it was that one, adds a bump of the logarithm of its
absence to an even rate. How wide bumps are is learnt as well, from how well absences were foretold
by those before: where robots stay away for any time, bumps are wide and tell little.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ReturnTimeTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    short_s: float = 5.0
    """A robot away for less has been missed by the detector, rather than dived, s. Judged."""
    least_share: float = 0.01
    """Share from which a robot may have been the one that came up. Judged."""
    largest_weight: float = 10.0
    """Weight of all absences together, against 1 for an even rate. Judged."""


TUNING = ReturnTimeTuning()


SCALES = np.array([0.01, 0.05, 0.2, 0.8])
"""Widths of bumps, of the logarithm of a time."""


class AbsenceTimes:
    """The law of absences of robots.

    Args:
        mean_s: of the even rate, s.
    """

    def __init__(self, mean_s: float) -> None:
        self._mean_s = max(mean_s, 1e-3)
        self.reset()

    def reset(self) -> None:
        """Forget all absences."""
        self._logs = np.zeros(0)
        self._weights = np.zeros(0)
        self._dives: list[Hashable] = []
        self._foretold = np.zeros(len(SCALES))

    def add(self, seconds: Array, shares: Array, dives: Sequence[Hashable] = ()) -> None:
        """Take in that one of several robots, which have been away for so long, came up.

        Args:
            seconds: (n,) from the last image with each robot to the first one again, s.
            shares: (n,) probability that it was that robot; less than 1 together.
            dives: n keys of the absences. Each ends once: what was taken in of it before, as
                another track came up that could have been that robot, then counts less.
        """
        ended = dict(zip(dives, shares.tolist(), strict=False))
        self._weights *= [1.0 - ended.get(dive, 0.0) for dive in self._dives]
        dived = (seconds >= TUNING.short_s) & (shares > TUNING.least_share)
        seconds, shares = seconds[dived], shares[dived]
        if not len(seconds):
            return
        density, _ = self._law(seconds)
        self._foretold += float(shares.sum()) * np.log(density @ shares / shares.sum())
        self._foretold -= self._foretold.max()
        self._logs = np.append(self._logs, np.log(seconds))
        self._weights = np.append(self._weights, shares)
        named = [dives[i] for i in np.flatnonzero(dived).tolist()] if dives else []
        self._dives += named or [None] * len(shares)

    def joint_log_density(self, seconds: Array) -> float:
        """Return the log density of the absences (n,) of robots that have all come up.

        Each foretells the next: robots that dived one after the other come up in that order.
        NaN: one that tells nothing.
        """
        law, total = AbsenceTimes(self._mean_s), 0.0
        law._logs, law._weights = self._logs, self._weights.copy()
        law._dives = [None] * len(self._dives)
        law._foretold = self._foretold.copy()
        for one in seconds.tolist():
            if math.isnan(one):
                total -= math.log(self._mean_s)
                continue
            density, _ = law._law(np.array([one]))
            share = np.exp(law._foretold)
            total += math.log(float(share @ density[:, 0]) / float(share.sum()))
            law.add(np.array([one]), np.ones(1))
        return total

    def odds(self, seconds: Array) -> Array:
        """Return how much likelier robots come up after such absences than at an even rate.

        The ratio of the rates at which robots that are still away come up.

        Args:
            seconds: of any shape, s; NaN: absences that tell nothing.
        """
        if not len(self._logs):
            return np.ones(seconds.shape)
        told = seconds >= TUNING.short_s
        density, left = self._law(np.where(told, seconds, TUNING.short_s).reshape(-1))
        share = np.exp(self._foretold)
        rate = share @ density / np.maximum(share @ left, 1e-12)
        odds: Array = np.where(told, (self._mean_s * rate).reshape(seconds.shape), 1.0)
        return odds

    def share(self, seconds: Array, unseen: Array) -> Array:
        """Return the even rate as a share (n, m) of that at which robots come back, at most 1.

        A robot that dived comes up at the even rate, until others tell more (`odds`). One that an
        image missed, or that left the view, comes back sooner the shorter it has been unseen.

        Args:
            seconds: (n, m) since it dived, s; NaN: it left the view.
            unseen: (n,) since it was seen, s.
        """
        missed = np.minimum(unseen / self._mean_s, 1.0)[:, None]
        time = np.maximum(seconds, TUNING.short_s)
        dived = 1.0 / (1.0 + self._mean_s / time * np.exp(-time / TUNING.short_s))
        share: Array = np.where(seconds >= TUNING.short_s, dived, missed)
        return share

    def _law(self, seconds: Array) -> tuple[Array, Array]:
        """Return the density, 1/s, and the share still away, (scales, n), by width of the bumps."""
        time = np.maximum(seconds, TUNING.short_s)
        off = (np.log(time)[:, None] - self._logs) / SCALES[:, None, None]
        total = float(self._weights.sum())
        weights = self._weights * min(1.0, TUNING.largest_weight / max(total, 1e-12))
        bumps = np.exp(-0.5 * off**2) @ weights / (math.sqrt(2.0 * math.pi) * SCALES[:, None])
        even = np.exp(-(time - TUNING.short_s) / self._mean_s)
        density = even / self._mean_s + bumps / time
        left = even + ndtr(-off) @ weights
        whole = 1.0 + float(weights.sum())
        return density / whole, left / whole
