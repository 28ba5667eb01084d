# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How often images miss a robot, and how often they show a box where there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass

from aerial_gnss_ros.core.association.assignment import TUNING as ASSIGNMENT


@dataclass(frozen=True)
class ClutterTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    fading_images: int = 300
    """Images after which what was counted has faded to a third. Judged."""
    rare_product: float = 1e-3
    """Product of the two rates from which a stray box beside a missing robot may well be a false
    one. Robots that swerve are counted in both; ten that cross reach 1e-4."""


TUNING = ClutterTuning()


def chance_probability(beside: int, tracks: int) -> float:
    """Return the probability that a false box lies in the gate of a new track by chance.

    Args:
        beside: boxes that belong to no track, within `ASSIGNMENT.near_gate_radii` times a new
            track's gate; each counts with every one.
        tracks: new ones.
    """
    return -math.expm1(-beside / (ASSIGNMENT.near_gate_radii**2 * max(tracks, 1)))


class Clutter:
    """Counts both over the last images.

    Attributes:
        stamp_ns: of the last one, ns.
    """

    def __init__(self) -> None:
        self.stamp_ns = 0
        self._images = self._stray = self._robots = self._missed = 0.0

    def update(self, stamp_ns: int, robots: int, missed: int, stray: int) -> None:
        """Take in an image.

        Args:
            stamp_ns: of the image, ns.
            robots: that should be in it.
            missed: of these, without a box.
            stray: boxes that belong to no track.
        """
        self.stamp_ns = stamp_ns
        fade = 1.0 - 1.0 / TUNING.fading_images
        self._images = fade * self._images + 1.0
        self._stray = fade * self._stray + stray
        self._robots = fade * self._robots + robots
        self._missed = fade * self._missed + missed

    @property
    def heavy(self) -> bool:
        """Whether an image often enough misses a robot and shows a false box at once."""
        return self._missed * self._stray > TUNING.rare_product * self._robots * self._images
