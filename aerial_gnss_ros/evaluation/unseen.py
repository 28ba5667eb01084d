# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Errors of predicted positions against the time since their robot was last seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse
from aerial_gnss_ros.core.values.samples import Array
from aerial_gnss_ros.evaluation.errors import RobotErrors, at_stamps

LEAST_S = 1.0
"""Robots unseen for less have only been missed by the detector in some images."""


@dataclass(frozen=True)
class Unseen:
    """One robot's predicted positions, where truth is known.

    Attributes:
        truth_id: name in the truth.
        seconds: (n,) since the robot was last measured, s.
        distance: (n,) horizontal error, m.
        sigma: (n,) published one sigma, root of the mean of both variances, m.
    """

    truth_id: str
    seconds: Array
    distance: Array
    sigma: Array


def unseen(
    robots: Sequence[RobotErrors],
    estimates: Mapping[str, EstimatedTrack],
    truth: Mapping[str, Track],
) -> list[Unseen]:
    """Return those robots that were out of sight for `LEAST_S` at least.

    Args:
        robots: which published label is which true robot.
        estimates: published tracks by robot id.
        truth: true tracks by truth id.
    """
    found = [
        _unseen(robot.truth_id, estimates[robot.robot_id], truth[robot.truth_id])
        for robot in robots
        if robot.robot_id
    ]
    return [one for one in found if one.seconds.max(initial=0.0) >= LEAST_S]


def _unseen(name: str, estimate: EstimatedTrack, truth: Track) -> Unseen:
    latitude, longitude, known = at_stamps(truth, estimate.stamps_ns)
    seen = np.flatnonzero(estimate.measured)
    index = np.flatnonzero(known & ~estimate.measured)
    last = np.searchsorted(seen, index) - 1
    index, last = index[last >= 0], last[last >= 0]
    distance, _, _ = geodesic_inverse(
        latitude[index], longitude[index], estimate.latitude[index], estimate.longitude[index]
    )
    variances = np.diagonal(estimate.covariance[index], axis1=1, axis2=2)
    seconds = 1e-9 * (estimate.stamps_ns[index] - estimate.stamps_ns[seen[last]]).astype(np.float64)
    return Unseen(name, seconds, np.asarray(distance), np.sqrt(variances.mean(axis=1)))
