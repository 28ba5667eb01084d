# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A track has moved if its distance to a reference changed by more than the errors explain."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.references.candidates import Candidate
from aerial_gnss_ros.core.references.position_law import PositionLaw
from aerial_gnss_ros.core.references.stationarity import StationarityTest

SECOND = 1_000_000_000
TRACKS = [SimpleNamespace(robot_id="buoy_1"), SimpleNamespace(robot_id="buoy_2")]


class Filter:
    """What the test reads of the filter: a receiver of 1 m whose offset lasts tau seconds."""

    def __init__(self, tau_s=1e9):
        self.believed = np.zeros(2)
        self.stationary = np.eye(COUNT)
        self.decay = lambda s: np.full(COUNT, np.exp(-s / tau_s))


def law(*places, sigma_m=0.0):
    mean = np.zeros(COUNT + 4 * len(places))
    mean[COUNT:].reshape(-1, 4)[:, :2] = places
    covariance = np.diag(np.r_[np.ones(COUNT), np.full(4 * len(places), 1.0 + sigma_m**2)])
    return PositionLaw(np.arange(len(places)), mean, covariance)


def mark(*rows):
    return Candidate("mark", np.zeros(2), np.zeros((2, 2)), rows, stays=True)


def moved(test, law, seconds, rows=(0,)):
    kept, found = test.update(mark(*rows), TRACKS, law, int(seconds * SECOND))
    return kept.rows, found


@pytest.mark.parametrize(("metres", "gone"), [(0.89, False), (0.91, True)])
def test_three_sigmas_of_apparent_motion(metres, gone):
    """0.3 m of box errors alone: the gate is at 0.9 m, in any direction."""
    for way in ((1, 0), (-1, 0), (0, 1), (0.6, -0.8)):
        test = StationarityTest(Filter())
        assert moved(test, law((5, 0)), 0.0) == ((0,), {})
        rows, found = moved(test, law(np.add((5, 0), np.multiply(way, metres))), 1.0)
        assert rows == (() if gone else (0,))
        assert found == ({"buoy_1": pytest.approx(metres)} if gone else {})


def test_each_uncertainty_widens_the_gate():
    """The track's own 1 m when first compared, or a receiver that drifts: 2 (1 - exp(-1)) m²."""
    test = StationarityTest(Filter())
    moved(test, law((5, 0), sigma_m=1.0), 0.0)
    assert moved(test, law((5 + 3 * 1.04, 0), sigma_m=1.0), 1.0)[0] == (0,)
    assert moved(test, law((5 + 3 * 1.05, 0), sigma_m=1.0), 1.0)[0] == ()
    gate = 3.0 * np.sqrt(2.0 * (1.0 - np.exp(-1.0)) + 0.09)
    for metres, rows in ((gate - 0.01, (0,)), (gate + 0.01, ())):
        test = StationarityTest(Filter(tau_s=10.0))
        moved(test, law((5, 0)), 0.0)
        assert moved(test, law((5 + metres, 0)), 10.0)[0] == rows


def test_one_that_has_moved_stays_excluded_and_is_reported_once():
    test = StationarityTest(Filter())
    moved(test, law((5, 0), (7, 0)), 0.0, (0, 1))
    assert moved(test, law((5, 2), (7, 0)), 1.0, (0, 1)) == ((1,), {"buoy_1": pytest.approx(2.0)})
    assert moved(test, law((5, 0), (7, 0)), 2.0, (0, 1)) == ((1,), {})


def test_an_accepted_jump_of_the_receiver_is_no_motion():
    filtering = Filter()
    test = StationarityTest(filtering)
    moved(test, law((5, 0)), 0.0)
    filtering.believed = np.array([3.0, 0.0])
    assert moved(test, law((8, 0)), 1.0) == ((0,), {})


def test_what_another_drone_told_of_the_receiver_is_no_motion():
    """Its offset was unknown by 1 m, then by 0.6 m: the track moves with it, by 0.8 m one sigma."""
    gate = 3.0 * np.sqrt(1.0 - 0.36 + 0.09)
    for metres, rows in ((gate - 0.01, (0,)), (gate + 0.01, ())):
        test = StationarityTest(Filter())
        moved(test, law((5, 0)), 0.0)
        told = law((5 + metres, 0))
        told.covariance[:2, :2] *= 0.36
        assert moved(test, told, 1.0)[0] == rows
