# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rates of missed detections and of clutter over the last images."""

from __future__ import annotations

import math
from dataclasses import dataclass

from aerial_gnss_ros.core.association.assignment import TUNING as ASSIGNMENT


@dataclass(frozen=True)
class ClutterTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    fading_images: int = 300
    """Images after which a count has decayed to a third. Judged."""
    prior_missed: tuple[float, float] = (0.5, 9.5)
    """Beta distribution of the share of robots that are missed, before any image. Judged: one in
    twenty, as if ten had been expected."""
    prior_false: tuple[float, float] = (0.2, 10.0)
    """Gamma distribution of the number of false boxes in an image: two in a hundred images, as if
    ten had been seen. Judged."""
    rare_product: float = 1e-3
    """Product of the two rates above which an unassociated box beside a missed robot may be
    clutter. Manoeuvring robots count in both rates; ten that cross reach 1e-4."""


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
    """Estimates both rates.

    Attributes:
        stamp_ns: of the last image, ns.
    """

    def __init__(self) -> None:
        self.stamp_ns = 0
        self.heavy = False
        self._images = self._unassociated = self._robots = self._missed = 0.0

    def update(self, stamp_ns: int, robots: int, missed: int, unassociated: int) -> None:
        """Update with an image.

        Args:
            stamp_ns: of the image, ns.
            robots: number of robots expected in it.
            missed: number of these without a box.
            unassociated: number of unassociated boxes.
        """
        self.stamp_ns = stamp_ns
        fade = 1.0 - 1.0 / TUNING.fading_images
        self._images = fade * self._images + 1.0
        self._unassociated = fade * self._unassociated + unassociated
        self._robots = fade * self._robots + robots
        self._missed = fade * self._missed + missed
        both, rare = self._missed * self._unassociated, TUNING.rare_product
        self.heavy = both > rare * self._robots * self._images

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
