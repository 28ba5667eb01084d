# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Identity scores on flights small enough to count by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.core.geometry.geodesy import geodetic_from_enu
from aerial_gnss_ros.evaluation.errors import compare
from aerial_gnss_ros.evaluation.identity import Scene, hota_scores, identities

FRAMES = 100
STAMPS = np.arange(FRAMES, dtype=np.int64) * 100_000_000


def _track(east: np.ndarray, shift: float = 0.0, sigma: float = 1.0) -> EstimatedTrack:
    latitude, longitude, _ = geodetic_from_enu(
        east + shift, np.full(FRAMES, shift), np.zeros(FRAMES), 0.23, -1.04, 0.0
    )
    covariance = np.tile(sigma**2 * np.eye(2), (FRAMES, 1, 1))
    return EstimatedTrack(STAMPS, latitude, longitude, covariance, np.ones(FRAMES, dtype=bool))


def _scores(first: np.ndarray, second: np.ndarray, shift: float = 0.0, sigma: float = 1.0):
    truth: dict[str, Track] = {"a": _track(np.zeros(FRAMES)), "b": _track(np.ones(FRAMES))}
    estimates = {"x": _track(first, shift, sigma), "y": _track(second, shift, sigma)}
    found = identities(estimates, truth, compare(estimates, truth), near_m=0.8)
    assert found is not None
    return found


def test_a_common_error_is_no_confusion() -> None:
    """Both 7 m off, as published, and 1 m apart: each still keeps its name."""
    found = _scores(np.zeros(FRAMES), np.ones(FRAMES), shift=5.0, sigma=5.0)
    assert found.hota == pytest.approx(1.0, abs=1e-6)


def test_a_name_that_was_never_on_its_robot_is_no_common_error() -> None:
    """20 m off with a published sigma of 1 m: alone, or beside a robot that is right."""
    wrong = {"x": _track(np.full(FRAMES, 20.0))}
    for more in ({}, {"y": _track(np.ones(FRAMES))}):
        truth = {"a": _track(np.zeros(FRAMES)), **({"b": more["y"]} if more else {})}
        estimates = {**wrong, **more}
        found = identities(estimates, truth, compare(estimates, truth), near_m=0.8)
        assert found is not None
        assert found.deta == pytest.approx(len(more) / (2.0 + len(more)), abs=1e-6)


def test_one_swap_half_way() -> None:
    half = np.where(np.arange(FRAMES) < FRAMES // 2, 0.0, 1.0)
    found = _scores(half, 1.0 - half)
    assert found.deta == pytest.approx(1.0)
    # each of the four pairs has 50 hits in 100 + 100 - 50 images
    assert found.assa == pytest.approx(1.0 / 3.0)
    assert found.hota == pytest.approx(math.sqrt(1.0 / 3.0))
    pytest.importorskip("motmetrics")
    assert (found.switches, found.idf1) == (2, pytest.approx(0.5))


def test_hota_of_a_tracker_that_sees_half() -> None:
    one = np.zeros(1, dtype=np.intp)
    none = np.zeros(0, dtype=np.intp)
    seen = Scene(one, one, np.zeros((1, 1)))
    unseen = Scene(one, none, np.zeros((1, 0)))
    hota, assa, deta = hota_scores([seen, unseen], near_m=1.0)
    assert (hota, assa, deta) == pytest.approx((0.5, 0.5, 0.5))
