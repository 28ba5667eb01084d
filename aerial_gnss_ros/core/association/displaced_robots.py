# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether robots without a box in their gates were missed by chance, or are displaced.

A detector misses robots and reports false boxes. Where it does so often, an image without the two
robots in view, but with a false box, comes every few seconds; where it hardly does, such an image
shows that all robots have been displaced. The log likelihood ratio of the two is added up over
successive images (Page 1954: a cumulative sum that never falls below zero).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from aerial_gnss_ros.core.association.clutter import Clutter


@dataclass(frozen=True)
class DisplacedRobotsTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    displaced_every_s: float = 300.0
    """Mean time between displacements, s. Judged."""


TUNING = DisplacedRobotsTuning()


class DisplacedRobots:
    """Adds up, image by image, how much likelier it is that all robots are displaced."""

    def __init__(self) -> None:
        self._nats = 0.0

    def reset(self) -> None:
        """Begin anew: an image has shown most robots where they are expected."""
        self._nats = 0.0

    def update(
        self, rates: Clutter, robots: int, matched: int, others: int, passed_s: float
    ) -> bool:
        """Update with an image that misses most robots; return whether they are displaced.

        Args:
            rates: of missed robots and of false boxes.
            robots: number of robots in view.
            matched: number of these with a box in their gates.
            others: number of boxes in no robot's gate.
            passed_s: time since the last image, s.
        """
        self._nats = max(0.0, self._nats + displaced_nats(rates, robots, matched, others))
        every_s = TUNING.displaced_every_s
        return self._nats > math.log(every_s / min(passed_s, every_s))


def displaced_nats(rates: Clutter, robots: int, matched: int, others: int) -> float:
    """Return the log likelihood ratio of displaced robots to missed ones.

    Of displaced robots any box may be one, and a box in a gate is there by chance.

    Args:
        rates: of missed robots and of false boxes.
        robots: number of robots in view.
        matched: number of these with a box in their gates.
        others: number of boxes in no robot's gate.
    """
    missed = rates.missed_nats(robots, robots - matched) + rates.false_nats(others)
    boxes = matched + others
    elsewhere = [
        rates.missed_nats(robots, robots - seen) + rates.false_nats(boxes - seen)
        for seen in range(min(robots, boxes) + 1)
    ]
    most = max(elsewhere)
    return most + math.log(sum(math.exp(one - most) for one in elsewhere)) - missed
