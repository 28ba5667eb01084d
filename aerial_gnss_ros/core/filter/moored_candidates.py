# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which swimming robots seem to stay, or to drift alike: with these a moored law begins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.moored_law import velocities_of, velocity_odds
from aerial_gnss_ros.core.filter.state import JointState

Array = NDArray[np.float64]


def likely_still(base: JointState, slots: list[int], least: float) -> list[int]:
    """Return the robots that are likelier to stay than to swim.

    Args:
        base: all robots.
        slots: those that are asked for.
        least: log odds from which one does, nats.
    """
    v = velocities_of(slots)
    odds = velocity_odds(base.mean[v], base.covariance[v[:, :, None], v[:, None]])
    return [slot for slot, one in zip(slots, odds.tolist(), strict=True) if one > least]


def most_alike(base: JointState, slots: list[int], least: float) -> int:
    """Return the robot with which most others seem to drift, -1: no two seem to.

    Args:
        base: all robots.
        slots: those that are asked for.
        least: log odds from which two drift alike, nats.
    """
    if len(slots) < 2:
        return -1
    v = velocities_of(slots)
    all_ = base.covariance[v[:, None, :, None], v[None, :, None]]
    every = np.arange(len(slots))
    own = all_[every, every]
    spread = own[:, None] + own - all_ - all_.swapaxes(2, 3)
    odds = velocity_odds(base.mean[v][:, None] - base.mean[v], spread)
    odds[every, every] = -np.inf
    scores = np.where(odds > least, odds, 0.0).sum(axis=1)
    # Of two robots that are each other's best, rounding would choose: hence the first one.
    best = int(np.argmax(scores > scores.max() - 1e-6))
    return slots[best] if scores[best] > 0.0 else -1
