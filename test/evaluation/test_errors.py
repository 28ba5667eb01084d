# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Errors against truth, with numbers that a hand can check."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.core.geometry.geodesy import geodetic_from_enu
from aerial_gnss_ros.evaluation.errors import compare, distances, summarise

LATITUDE, LONGITUDE = math.radians(13.19), math.radians(-59.64)
STEP_NS = 100_000_000


def _place(east: np.ndarray, north: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    latitude, longitude, _ = geodetic_from_enu(
        east, north, np.zeros_like(east), LATITUDE, LONGITUDE, 0.0
    )
    return np.asarray(latitude), np.asarray(longitude)


def _truth(east: float, count: int = 50) -> Track:
    stamps = np.arange(count, dtype=np.int64) * STEP_NS + 1_700_000_000_000_000_000
    return Track(stamps, *_place(np.full(count, east), np.zeros(count)))


def _estimate(east: float, north: float, first: int = 0, count: int = 50) -> EstimatedTrack:
    stamps = (np.arange(count) + first).astype(np.int64) * STEP_NS + 1_700_000_000_000_000_000
    covariance = np.tile(np.diag([4.0, 1.0]), (count, 1, 1))
    place = _place(np.full(count, east), np.full(count, north))
    return EstimatedTrack(stamps, *place, covariance, np.ones(count, dtype=bool))


def test_a_constant_offset() -> None:
    robots = compare({"aqua_1": _estimate(2.0, 1.0)}, {"aqua_1": _truth(0.0)})
    summary = summarise(robots)
    assert summary.count == 50
    assert summary.mean_east == pytest.approx(2.0, abs=1e-4)
    assert summary.mean_north == pytest.approx(1.0, abs=1e-4)
    assert summary.median == pytest.approx(math.sqrt(5.0), abs=1e-4)
    assert summary.nees == pytest.approx(2.0**2 / 4.0 + 1.0, abs=1e-3)
    assert summary.sigma == pytest.approx(math.sqrt(2.5))
    assert robots[0].coverage == 1.0


def test_two_methods_are_compared_image_by_image() -> None:
    """Of one robot three of five images are common; the other one was never found by the second."""
    truth = {"aqua_1": _truth(0.0), "aqua_2": _truth(50.0)}
    some = compare({"a": _estimate(2.0, 1.0, 0, 5), "b": _estimate(50.0, 0.0)}, truth)
    others = compare({"x": _estimate(5.0, -3.0, 2, 5)}, truth)
    assert distances(some, others) == pytest.approx([5.0, 5.0, 5.0], rel=1e-6)


def test_one_name_belongs_to_one_robot_for_the_whole_flight() -> None:
    """Names that are swapped half-way are scored as errors, not with the nearest robot."""
    truth = {"a": _truth(0.0), "b": _truth(10.0)}
    half = np.arange(50) < 25
    first = _estimate(0.0, 0.0)
    swapped = _place(np.where(half, 0.0, 10.0), np.zeros(50))
    other = _place(np.where(half, 10.0, 0.0), np.zeros(50))
    estimates = {
        "aqua_1": EstimatedTrack(first.stamps_ns, *swapped, first.covariance, first.measured),
        "aqua_2": EstimatedTrack(first.stamps_ns, *other, first.covariance, first.measured),
    }
    assert summarise(compare(estimates, truth)).p95 == pytest.approx(10.0, abs=1e-3)


def test_names_need_not_agree_and_a_short_false_track_loses() -> None:
    truth = {"a": _truth(0.0), "b": _truth(10.0)}
    estimates = {
        "aqua_1": _estimate(10.5, 0.0),
        "aqua_2": _estimate(0.5, 0.0),
        "aqua_3": _estimate(0.0, 0.0, first=20, count=4),
    }
    assert [robot.robot_id for robot in compare(estimates, truth)] == ["aqua_2", "aqua_1"]


def test_a_robot_never_found_counts_in_availability() -> None:
    robots = compare(
        {"aqua_1": _estimate(0.0, 0.0, count=25)}, {"a": _truth(0.0), "b": _truth(9.0)}
    )
    assert robots[0].coverage == pytest.approx(0.6, abs=0.021)  # 2.5 s, and 0.5 s after it
    assert (robots[1].robot_id, robots[1].coverage, len(robots[1].east_north)) == ("", 0.0, 0)
    assert math.isnan(summarise([robots[1]]).median)
