# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One reference, the first of some tracks of known law, for tests of what shows that it stays."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.references.candidates import Candidate
from aerial_gnss_ros.core.references.position_law import PositionLaw

SECOND = 1_000_000_000


class Filter:
    """What is read of the filter: a receiver of 1 m whose offset lasts tau seconds."""

    def __init__(self, tau_s: float = 1e9) -> None:
        self.believed = np.zeros(2)
        self.stationary = np.eye(COUNT)
        self.decay = lambda s: np.full(COUNT, np.exp(-s / tau_s))


def law(*places, sigma_m=0.0, mps=0.0, sigma_mps=1.0):
    """Return tracks at places, the first of which seems to swim East."""
    mean = np.zeros(COUNT + 4 * len(places))
    mean[COUNT:].reshape(-1, 4)[:, :2] = places
    mean[COUNT + 2] = mps
    own = np.r_[np.full(2, 1.0 + sigma_m**2), np.full(2, sigma_mps**2)]
    covariance = np.diag(np.r_[np.ones(COUNT), np.tile(own, len(places))])
    return PositionLaw(np.arange(len(places)), mean, covariance)


def mark(at=(0.0, 0.0), crowded=False, stays=True, rows=(0,), sigma_m=0.0):
    return Candidate("mark", np.array(at), sigma_m**2 * np.eye(2), rows, crowded, stays)


def tracks_of(law, seconds, names=()):
    """Return the tracks of a law, all in view: buoy_0, buoy_1, ... but for some names."""
    rest = [f"buoy_{i}" for i in range(len(names), len(law.rows))]
    stamp_ns = round(seconds * SECOND)
    return [SimpleNamespace(robot_id=name, last_seen_ns=stamp_ns) for name in (*names, *rest)]
