# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Distribution of absences: how long robots stay submerged, learnt from those that returned.

Robots of one mission dive alike: one that has been away as long as others were is likelier to
surface than one that has just dived. The prior is a constant rate. Each returned robot adds a
kernel in the logarithm of its absence, weighted by the probability that it was that robot. The
kernel width is learnt from how well earlier absences predicted the later ones: where absences vary
much, kernels are wide and carry little information.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.numerics.normal_law import normal_share

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ReturnTimeTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    short_s: float = 5.0
    """A robot away for less was missed by the detector rather than submerged, s. Judged."""
    least_share: float = 0.01
    """Least probability at which an absence is learnt. Judged."""
    largest_weight: float = 10.0
    """Weight of all absences together, relative to the constant rate. Judged."""


TUNING = ReturnTimeTuning()


SCALES = np.array([0.01, 0.05, 0.2, 0.8])
"""Kernel widths, of the logarithm of a time."""


class AbsenceTimes:
    """Distribution of robots' absences.

    Args:
        mean_s: mean absence at the constant rate, s.
    """

    def __init__(self, mean_s: float) -> None:
        self._mean_s = max(mean_s, 1e-3)
        self.reset()

    def reset(self) -> None:
        """Forget all absences."""
        self._logs = np.zeros(0)
        self._weights = np.zeros(0)
        self._dives: list[Hashable] = []
        self._log_scores = np.zeros(len(SCALES))

    def add(self, seconds: Array, shares: Array, dives: Sequence[Hashable] = ()) -> None:
        """Learn from a track that surfaced: one of several robots, with these absences.

        Args:
            seconds: (n,) from the last image with each robot to the first with the track, s.
            shares: (n,) probability of each robot to be the track; their sum is at most 1.
            dives: n keys of the absences. Each ends once: what an earlier track contributed to it
                is reduced.
        """
        ended = dict(zip(dives, shares.tolist(), strict=False))
        self._weights *= [1.0 - ended.get(dive, 0.0) for dive in self._dives]
        dived = (seconds >= TUNING.short_s) & (shares > TUNING.least_share)
        seconds, shares = seconds[dived], shares[dived]
        if not len(seconds):
            return
        density, _ = self._density(seconds)
        self._log_scores += float(shares.sum()) * np.log(density @ shares / shares.sum())
        self._log_scores -= self._log_scores.max()
        self._logs = np.append(self._logs, np.log(seconds))
        self._weights = np.append(self._weights, shares)
        named = [dives[i] for i in np.flatnonzero(dived).tolist()] if dives else []
        self._dives += named or [None] * len(shares)

    def joint_log_density(self, seconds: Array) -> float:
        """Return the joint log density of absences (n,) of robots that have all surfaced.

        Each one predicts the next: robots that dived one after the other surface in that order. NaN
        marks an absence without information.
        """
        law, total = AbsenceTimes(self._mean_s), 0.0
        law._logs, law._weights = self._logs, self._weights.copy()
        law._dives = [None] * len(self._dives)
        law._log_scores = self._log_scores.copy()
        for one in seconds.tolist():
            if math.isnan(one):
                total -= math.log(self._mean_s)
                continue
            density, _ = law._density(np.array([one]))
            share = np.exp(law._log_scores)
            total += math.log(float(share @ density[:, 0]) / float(share.sum()))
            law.add(np.array([one]), np.ones(1))
        return total

    def odds(self, seconds: Array) -> Array:
        """Return the ratio of the return rates after absences to the constant rate.

        Rates are those of robots that are still away.

        Args:
            seconds: absences of any shape, s; NaN where without information.
        """
        if not len(self._logs):
            return np.ones(seconds.shape)
        informative = seconds >= TUNING.short_s
        density, left = self._density(np.where(informative, seconds, TUNING.short_s).reshape(-1))
        share = np.exp(self._log_scores)
        rate = share @ density / np.maximum(share @ left, 1e-12)
        odds: Array = np.where(informative, (self._mean_s * rate).reshape(seconds.shape), 1.0)
        return odds

    def share(self, seconds: Array, unseen: Array) -> Array:
        """Return the ratio (n, m) of the constant rate to the present return rate, at most 1.

        A submerged robot surfaces at the constant rate until absences are learnt (`odds`). One that
        the detector missed, or that left the view, returns the sooner the shorter it has been
        unseen.

        Args:
            seconds: (n, m) since it dived, s; NaN: it left the view.
            unseen: (n,) since it was last seen, s.
        """
        missed = np.minimum(unseen / self._mean_s, 1.0)[:, None]
        time = np.maximum(seconds, TUNING.short_s)
        dived = 1.0 / (1.0 + self._mean_s / time * np.exp(-time / TUNING.short_s))
        share: Array = np.where(seconds >= TUNING.short_s, dived, missed)
        return share

    def _density(self, seconds: Array) -> tuple[Array, Array]:
        """Return the density, 1/s, and the share still away, (scales, n), by kernel width."""
        time = np.maximum(seconds, TUNING.short_s)
        off = (np.log(time)[:, None] - self._logs) / SCALES[:, None, None]
        total = float(self._weights.sum())
        weights = self._weights * min(1.0, TUNING.largest_weight / max(total, 1e-12))
        bumps = np.exp(-0.5 * off**2) @ weights / (math.sqrt(2.0 * math.pi) * SCALES[:, None])
        even = np.exp(-(time - TUNING.short_s) / self._mean_s)
        density = even / self._mean_s + bumps / time
        left = even + normal_share(-off) @ weights
        whole = 1.0 + float(weights.sum())
        return density / whole, left / whole
