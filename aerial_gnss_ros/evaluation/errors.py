# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Errors of published positions against truth, on the WGS84 ellipsoid."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse, haversine
from aerial_gnss_ros.core.numerics.linear_assignment import linear_sum_assignment
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.samples import Array

Stamps = NDArray[np.int64]
_MISSED_M = 20.0
STRANGE_M = 10_000.0
"""Distance beyond which truth cannot be of this flight, m."""
_NEAR_NS = 500_000_000
_BRIDGED_NS = 10_000_000_000
"""Truth is not interpolated between samples farther apart."""


@dataclass(frozen=True)
class RobotErrors:
    """One robot's errors at stamps with a measured position and known truth.

    Attributes:
        truth_id: name in the truth.
        robot_id: label given by the estimator, or "" if it was never tracked.
        stamps_ns: (n,) stamps compared.
        east_north: (n, 2) estimate minus truth, m.
        nees: (n,) squared Mahalanobis distance of the error by the published covariance.
        sigma: (n,) published one sigma, root of the mean of both variances, m.
        coverage: share of truth samples with a measured position within 0.5 s.
        haversine: (n,) distance on the sphere, m, as in the paper; up to 0.6 % wrong.
        range_m: (n,) horizontal distance from the drone to truth, m; NaN where unknown.
        sigmas: (n, 2) published one sigma, East and North, m.
    """

    truth_id: str
    robot_id: str
    stamps_ns: Stamps
    east_north: Array
    nees: Array
    sigma: Array
    coverage: float
    haversine: Array = field(default_factory=lambda: np.zeros(0))
    range_m: Array = field(default_factory=lambda: np.zeros(0))
    sigmas: Array = field(default_factory=lambda: np.zeros((0, 2)))

    @property
    def distance(self) -> Array:
        """Horizontal error, (n,) m."""
        return np.asarray(np.hypot(self.east_north[:, 0], self.east_north[:, 1]))


@dataclass(frozen=True)
class Summary:
    """Statistics of a set of errors, m; NaN without errors.

    The median is the CEP: the circle round truth that holds half of the positions; ce90 holds 90 %.
    """

    count: int
    median: float
    p95: float
    rmse: float
    mean_east: float
    mean_north: float
    nees: float
    sigma: float
    ce90: float = float("nan")
    rmse_east: float = float("nan")
    rmse_north: float = float("nan")
    haversine_rmse: float = float("nan")

    def figures(self) -> dict[str, float | int | None]:
        """Return every figure by name, CEP too; None in place of NaN, which JSON lacks."""
        named = {**asdict(self), "cep": self.median}
        return {name: None if math.isnan(value) else value for name, value in named.items()}


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
        float(np.percentile(distance, 90)),
        float(np.sqrt(np.mean(error[:, 0] ** 2))),
        float(np.sqrt(np.mean(error[:, 1] ** 2))),
        float(np.sqrt(np.mean(np.concatenate([robot.haversine for robot in found]) ** 2))),
    )


def distances(some: Sequence[RobotErrors], others: Sequence[RobotErrors]) -> Array:
    """Return the distances (n,) of two positions of one robot in one image, m.

    Args:
        some: of all robots, as `compare` orders them.
        others: the same by another method.
    """
    found = [np.zeros(0)]
    for one, other in zip(some, others, strict=True):
        _, first, second = np.intersect1d(one.stamps_ns, other.stamps_ns, return_indices=True)
        found.append(np.linalg.norm(one.east_north[first] - other.east_north[second], axis=1))
    return np.concatenate(found)


def refuse_strangers(estimates: Mapping[str, EstimatedTrack], truth: Mapping[str, Track]) -> None:
    """Refuse truth that cannot be of this flight: at another time or far away.

    Args:
        estimates: published tracks by robot id; without any, nothing is refused.
        truth: true tracks by truth id.

    Raises:
        InputError: no stamp in common, or all positions farther than `STRANGE_M` from truth.
    """
    if not estimates or not truth:
        return
    apart = [_difference(e, t)[0] for e in estimates.values() for t in truth.values()]
    distance = np.concatenate([np.hypot(*error.T) for error in apart])
    if len(distance) and distance.min() > STRANGE_M:
        raise InputError(
            f"truth is at least {distance.min() * 1e-3:.0f} km from all positions: it may be of "
            "another flight, or have latitude and longitude exchanged."
        )
    if not len(distance) and not _overlap(estimates, truth):
        ours, theirs = (_span(tracks) for tracks in (estimates, truth))
        raise InputError(
            f"truth and positions have no time in common: truth is from {theirs} ns, positions "
            f"from {ours} ns; stamps are nanoseconds since 1970 on the clock of the images."
        )


def _overlap(estimates: Mapping[str, Track], truth: Mapping[str, Track]) -> bool:
    return any(
        e.stamps_ns[0] <= t.stamps_ns[-1] and t.stamps_ns[0] <= e.stamps_ns[-1]
        for e in estimates.values()
        for t in truth.values()
    )


def _span(tracks: Mapping[str, Track]) -> str:
    first = min(int(track.stamps_ns[0]) for track in tracks.values())
    return f"{first} to {max(int(track.stamps_ns[-1]) for track in tracks.values())}"


def compare(
    estimates: Mapping[str, EstimatedTrack],
    truth: Mapping[str, Track],
    drone: Track | None = None,
) -> list[RobotErrors]:
    """Match each true robot with one label for the whole flight, and return the errors.

    One label belongs to one true robot throughout, by least total distance: scoring each image with
    the nearest robot (as the paper's code does, reference C7) would hide identity switches.

    Args:
        estimates: published tracks by robot id.
        truth: true tracks by truth id.
        drone: its path, for ranges.

    Returns:
        One entry per true robot, sorted by truth id; robots never tracked have no errors.
    """
    pairs = _assign(estimates, truth)
    return [
        _errors(name, truth[name], pairs.get(name, ""), estimates, drone) for name in sorted(truth)
    ]


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
    # A short false track may coincide with a robot, so each missing position costs, too.
    lacking = overlap.max(axis=1, keepdims=True) - overlap
    rows, columns = linear_sum_assignment(total + lacking * _MISSED_M)
    return {names[i]: robots[j] for i, j in zip(rows, columns, strict=True) if overlap[i, j]}


def at_stamps(track: Track, stamps: Stamps) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return interpolated latitude and longitude (n,) rad at stamps (n,), and which are known.

    Positions are unknown outside the track and between samples more than 10 s apart.
    """
    after = np.clip(np.searchsorted(track.stamps_ns, stamps), 0, len(track) - 1)
    before = np.maximum(after - 1, 0)
    exact = track.stamps_ns[after] == stamps
    known = exact | (track.stamps_ns[after] - track.stamps_ns[before] <= _BRIDGED_NS)
    known &= (stamps >= track.stamps_ns[0]) & (stamps <= track.stamps_ns[-1])
    first = track.stamps_ns[0]  # floats represent ns exactly only over short spans
    seconds, knots = (stamps - first) * 1e-9, (track.stamps_ns - first) * 1e-9
    latitude = np.interp(seconds, knots, track.latitude)
    longitude = np.interp(seconds, knots, np.unwrap(track.longitude))
    return latitude, longitude, known


def _difference(estimate: EstimatedTrack, truth: Track) -> tuple[Array, NDArray[np.intp]]:
    """East, North differences (m, 2) at the measured stamps within truth, and their indices."""
    latitude, longitude, known = at_stamps(truth, estimate.stamps_ns)
    index = np.flatnonzero(known & estimate.measured)
    if not len(index):
        return np.zeros((0, 2)), index
    distance, azimuth, _ = geodesic_inverse(
        latitude[index], longitude[index], estimate.latitude[index], estimate.longitude[index]
    )
    error = np.stack([distance * np.sin(azimuth), distance * np.cos(azimuth)], axis=-1)
    return error, index


def _errors(
    name: str,
    truth: Track,
    robot: str,
    estimates: Mapping[str, EstimatedTrack],
    drone: Track | None,
) -> RobotErrors:
    if not robot:
        none = np.zeros(0)
        return RobotErrors(name, "", none.astype(np.int64), np.zeros((0, 2)), none, none, 0.0)
    estimate = estimates[robot]
    error, index = _difference(estimate, truth)
    covariance, stamps = estimate.covariance[index], estimate.stamps_ns[index]
    nees = np.einsum("ni,ni->n", error, np.linalg.solve(covariance, error[..., None])[..., 0])
    variances = np.diagonal(covariance, axis1=1, axis2=2)
    sigma = np.sqrt(variances.mean(axis=1))
    measured = estimate.stamps_ns[estimate.measured]
    latitude, longitude, _ = at_stamps(truth, stamps)
    sphere = haversine(latitude, longitude, estimate.latitude[index], estimate.longitude[index])
    away = np.full(len(index), np.nan)
    if drone is not None and len(drone) and len(index):
        drone_latitude, drone_longitude, known = at_stamps(drone, stamps)
        distance, _, _ = geodesic_inverse(drone_latitude, drone_longitude, latitude, longitude)
        away = np.where(known, distance, np.nan)
    return RobotErrors(
        name, robot, stamps, error, nees, sigma, _coverage(measured, truth),
        np.asarray(sphere), away, np.sqrt(variances),
    )  # fmt: skip


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
