# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Predictions are compared with truth by the time since their robot was last measured."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse
from aerial_gnss_ros.evaluation.errors import compare
from aerial_gnss_ros.evaluation.unseen import unseen

SECOND = 1_000_000_000
EARTH_M = 6.34e6  # at this latitude, along the meridian


def tracks(states, interval_s=1.0):
    """Return estimates that run north of truth, 1 m a sample, in these states; and the truth."""
    n = len(states)
    stamps = (np.arange(n) * interval_s * SECOND).astype(np.int64)
    truth = Track(stamps, np.full(n, 0.2), np.full(n, -1.0))
    north = 0.2 + np.arange(n) / EARTH_M
    covariance = np.stack([np.diag([4.0 * k, 12.0 * k]) for k in range(1, n + 1)])
    measured = np.array([state == "c" for state in states])
    return {"a": EstimatedTrack(stamps, north, truth.longitude, covariance, measured)}, {"t": truth}


def test_time_error_and_sigma_are_of_the_predictions_alone():
    estimates, truth = tracks("ccc___c__")
    [found] = unseen(compare(estimates, truth), estimates, truth)
    assert found.truth_id == "t"
    assert found.seconds.tolist() == [1.0, 2.0, 3.0, 1.0, 2.0]
    assert found.distance == pytest.approx([3.0, 4.0, 5.0, 7.0, 8.0], rel=0.01)
    assert found.sigma == pytest.approx(np.sqrt([32.0, 40.0, 48.0, 64.0, 72.0]))
    exact, _, _ = geodesic_inverse(0.2, -1.0, estimates["a"].latitude[3], -1.0)
    assert found.distance[0] == pytest.approx(float(exact))


def test_a_missed_box_is_no_absence_and_truth_must_be_known():
    estimates, truth = tracks("cc_c_c_c", interval_s=0.2)
    assert unseen(compare(estimates, truth), estimates, truth) == []
    estimates, truth = tracks("ccc___")
    half = Track(*(column[:5] for column in (truth["t"].stamps_ns, truth["t"].latitude,
                                             truth["t"].longitude)))  # fmt: skip
    [found] = unseen(compare(estimates, {"t": half}), estimates, {"t": half})
    assert found.seconds.tolist() == [1.0, 2.0]
    assert unseen(compare({}, truth), {}, truth) == []
