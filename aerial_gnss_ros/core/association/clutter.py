# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rates of missed detections and of clutter over the last images."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.assignment import TUNING as ASSIGNMENT

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ClutterTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    fading_images: int = 300
    """Images after which a count has decayed to a third. Judged."""
    prior_missed: tuple[float, float] = (0.5, 9.5)
    """Beta distribution of the share of robots that are missed, before any image. Judged: one in
    twenty, as if ten had been expected."""
    prior_false: tuple[float, float] = (0.2, 10.0)
    """Gamma distribution of the number of false boxes in an image, and of those beside a robot's
    gate, before any image. Judged: two in a hundred, as if ten had been seen."""
    doubtful_odds: float = 0.05
    """Odds of clutter to a robot's own box from which its gate is too wide for one box. Judged."""


TUNING = ClutterTuning()


def chance_probability(beside: int, tracks: int) -> float:
    """Return the probability that clutter lies in the gate of a new track.

    Args:
        beside: unassociated boxes within `ASSIGNMENT.near_gate_radii` times a new track's gate,
            counted once for each such track.
        tracks: number of new tracks.
    """
    return -math.expm1(-beside / (ASSIGNMENT.near_gate_radii**2 * max(tracks, 1)))


class Clutter:
    """Estimates these rates.

    Attributes:
        stamp_ns: of the last image, ns.
    """

    def __init__(self) -> None:
        self.stamp_ns = 0
        self._images = self._unassociated = self._robots = self._missed = 0.0
        self._beside = self._gates = self._log_sizes = 0.0

    def update(
        self,
        stamp_ns: int,
        robots: int,
        missed: int,
        unassociated: int,
        beside: int = 0,
        log_sizes: Sequence[float] = (),
    ) -> None:
        """Update with an image.

        Args:
            stamp_ns: of the image, ns.
            robots: number of robots expected in it.
            missed: number of these without a box.
            unassociated: number of unassociated boxes.
            beside: number of robots without a box in their gate that have one near it.
            log_sizes: of robots' gates with a box, log determinants of their covariances.
        """
        self.stamp_ns = stamp_ns
        fade = 1.0 - 1.0 / TUNING.fading_images
        self._images = fade * self._images + 1.0
        self._unassociated = fade * self._unassociated + unassociated
        self._robots = fade * self._robots + robots
        self._missed = fade * self._missed + missed
        self._beside = fade * self._beside + beside
        self._gates = fade * self._gates + len(log_sizes)
        self._log_sizes = fade * self._log_sizes + sum(log_sizes)

    @property
    def seen_share(self) -> float:
        """Share of the robots in view that images show."""
        one, other = TUNING.prior_missed
        return (other + self._robots - self._missed) / (one + other + self._robots)

    def doubtful(self, log_sizes: Array) -> NDArray[np.bool_]:
        """Return whether the only box in a robot's gate may well be clutter (n,).

        Either the image shows the robot, or it misses it and clutter lies in its gate. Of that
        there is as much as near the gates of late, in proportion to the area.

        Args:
            log_sizes: (n,) log determinants of the gates' covariances.
        """
        usual = self._log_sizes / self._gates if self._gates else math.inf
        larger = np.exp(0.5 * np.maximum(log_sizes - usual, 0.0))
        count, robots = TUNING.prior_false
        around = (count + self._beside) / (robots + self._robots)
        clutter = around / (ASSIGNMENT.near_gate_radii**2 - 1.0) * larger
        seen = self.seen_share
        return np.asarray((1.0 - seen) * clutter > TUNING.doubtful_odds * seen)

    def missed_nats(self, robots: int, missed: int) -> float:
        """Return the log probability that an image misses so many of some robots.

        Beta-binomial: the share that is missed is known no better than from the images so far.
        """
        prior = TUNING.prior_missed
        one, other = prior[0] + self._missed, prior[1] + self._robots - self._missed
        ways = _log_factorial(robots) - _log_factorial(missed) - _log_factorial(robots - missed)
        return ways + _log_beta(one + missed, other + robots - missed) - _log_beta(one, other)

    def false_nats(self, boxes: int) -> float:
        """Return the log probability that an image has so many false boxes.

        Negative binomial: Poisson with a rate that is known no better than from the images so far.
        """
        shape, images = TUNING.prior_false[0] + self._unassociated, TUNING.prior_false[1]
        images += self._images
        ways = math.lgamma(shape + boxes) - math.lgamma(shape) - _log_factorial(boxes)
        return ways + shape * math.log(images / (images + 1.0)) - boxes * math.log(images + 1.0)


def _log_factorial(n: int) -> float:
    return math.lgamma(n + 1.0)


def _log_beta(one: float, other: float) -> float:
    return math.lgamma(one) + math.lgamma(other) - math.lgamma(one + other)
