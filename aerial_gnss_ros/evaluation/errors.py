# SPDX-License-Identifier: Apache-2.0
"""Errors of published positions against truth, on the WGS84 ellipsoid."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.core.geodesy import geodesic_inverse
from aerial_gnss_ros.core.values import Array

Stamps = NDArray[np.int64]
_MISSED_M = 20.0
_NEAR_NS = 500_000_000


@dataclass(frozen=True)
class RobotErrors:
    """One robot's errors where it was measured and truth is known.

    Attributes:
        truth_id: name in the truth.
        robot_id: name that the estimator gave, or "" when it was never found.
        stamps_ns: (n,) stamps compared.
        east_north: (n, 2) estimate minus truth, m.
        nees: (n,) squared Mahalanobis distance of the error by the published covariance.
        sigma: (n,) published one sigma, root of the mean of both variances, m.
        coverage: share of truth's samples with a measured position within 0.5 s.
    """

    truth_id: str
    robot_id: str
    stamps_ns: Stamps
    east_north: Array
    nees: Array
    sigma: Array
    coverage: float

    @property
    def distance(self) -> Array:
        """Horizontal error, (n,) m."""
        return np.asarray(np.hypot(self.east_north[:, 0], self.east_north[:, 1]))


@dataclass(frozen=True)
class Summary:
    """Figures over a set of errors, m; NaN where there are none."""

    count: int
    median: float
    p95: float
    rmse: float
    mean_east: float
    mean_north: float
    nees: float
    sigma: float


def summarise(robots: list[RobotErrors]) -> Summary:
    """Return median, 95th percentile, RMSE, mean error, mean NEES and mean sigma."""
    found = [robot for robot in robots if len(robot.east_north)]
    if not found:
        nan = float("nan")
        return Summary(0, nan, nan, nan, nan, nan, nan, nan)
    error = np.concatenate([robot.east_north for robot in found])
    distance = np.hypot(error[:, 0], error[:, 1])
    return Summary(
        len(distance),
        float(np.median(distance)),
        float(np.percentile(distance, 95)),
        float(np.sqrt(np.mean(distance**2))),
        float(np.mean(error[:, 0])),
        float(np.mean(error[:, 1])),
        float(np.mean(np.concatenate([robot.nees for robot in found]))),
        float(np.mean(np.concatenate([robot.sigma for robot in found]))),
    )


def compare(
    estimates: Mapping[str, EstimatedTrack], truth: Mapping[str, Track]
) -> list[RobotErrors]:
    """Match each true robot with one estimated robot for the whole flight, and take errors.

    One estimated name belongs to one true robot throughout, by least total distance: scoring each
    frame with the nearest robot (as the paper's code does, reference C7) would hide a switch of
    identity.

    Args:
        estimates: published tracks by robot id.
        truth: true tracks by truth id.

    Returns:
        One entry a true robot, ordered by truth id; those never found have no errors.
    """
    pairs = _assign(estimates, truth)
    return [_errors(name, truth[name], pairs.get(name, ""), estimates) for name in sorted(truth)]


def _assign(estimates: Mapping[str, EstimatedTrack], truth: Mapping[str, Track]) -> dict[str, str]:
    names, robots = sorted(truth), sorted(estimates)
    if not names or not robots:
        return {}
    total, overlap = np.zeros((2, len(names), len(robots)))
    for i, name in enumerate(names):
        for j, robot in enumerate(robots):
            error, _ = _difference(estimates[robot], truth[name])
            overlap[i, j] = len(error)
            total[i, j] = np.minimum(np.hypot(error[:, 0], error[:, 1]), _MISSED_M).sum()
    # A short false track may lie exactly on a robot: each position that it lacks costs too.
    lacking = overlap.max(axis=1, keepdims=True) - overlap
    rows, columns = linear_sum_assignment(total + lacking * _MISSED_M)
    return {names[i]: robots[j] for i, j in zip(rows, columns, strict=True) if overlap[i, j]}


def _difference(estimate: EstimatedTrack, truth: Track) -> tuple[Array, NDArray[np.intp]]:
    """East, North differences (m, 2) at the measured stamps within truth, and their indices."""
    stamps = estimate.stamps_ns
    inside = (stamps >= truth.stamps_ns[0]) & (stamps <= truth.stamps_ns[-1])
    index = np.flatnonzero(inside & estimate.measured)
    if not len(index):
        return np.zeros((0, 2)), index
    first = truth.stamps_ns[0]  # floats hold ns exactly only for short spans
    seconds, knots = (stamps[index] - first) * 1e-9, (truth.stamps_ns - first) * 1e-9
    latitude = np.interp(seconds, knots, truth.latitude)
    longitude = np.interp(seconds, knots, np.unwrap(truth.longitude))
    distance, azimuth, _ = geodesic_inverse(
        latitude, longitude, estimate.latitude[index], estimate.longitude[index]
    )
    error = np.stack([distance * np.sin(azimuth), distance * np.cos(azimuth)], axis=-1)
    return error, index


def _errors(
    name: str, truth: Track, robot: str, estimates: Mapping[str, EstimatedTrack]
) -> RobotErrors:
    if not robot:
        none = np.zeros(0)
        return RobotErrors(name, "", none.astype(np.int64), np.zeros((0, 2)), none, none, 0.0)
    estimate = estimates[robot]
    error, index = _difference(estimate, truth)
    covariance = estimate.covariance[index]
    nees = np.einsum("ni,ni->n", error, np.linalg.solve(covariance, error[..., None])[..., 0])
    sigma = np.sqrt(np.trace(covariance, axis1=1, axis2=2) / 2.0)
    measured = estimate.stamps_ns[estimate.measured]
    return RobotErrors(
        name, robot, estimate.stamps_ns[index], error, nees, sigma, _coverage(measured, truth)
    )


def _coverage(measured: Stamps, truth: Track) -> float:
    if not len(measured):
        return 0.0
    after = np.searchsorted(measured, truth.stamps_ns)
    before = np.clip(after - 1, 0, len(measured) - 1)
    after = np.clip(after, 0, len(measured) - 1)
    nearest = np.minimum(
        np.abs(measured[after] - truth.stamps_ns), np.abs(truth.stamps_ns - measured[before])
    )
    return float(np.mean(nearest <= _NEAR_NS))
