# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Agreement of a drone with the others, and its receiver's offset to theirs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.fleet.agreement import Agreement, receiver_offset
from aerial_gnss_ros.core.fleet.shared_state import SharedState
from aerial_gnss_ros.core.models.platform_model import COUNT


def test_residuals_as_large_as_expected_agree():
    one = Agreement()
    assert math.isnan(one.ratio)
    for _ in range(50):
        one.add(6.0, 6, 0, 3)
    assert one.ratio == 1.0
    assert not one.disagrees


def test_a_drone_whose_boxes_are_refused_disagrees_after_a_while():
    one = Agreement()
    for k in range(40):
        one.add(2.0, 2, 1, 3)
        assert one.disagrees == (k >= 19)
    for _ in range(100):
        one.add(6.0, 6, 0, 3)
    assert not one.disagrees


def test_a_drone_whose_residuals_are_too_large_disagrees():
    for size, disagrees in ((1.5, False), (2.5, True)):
        one = Agreement()
        for k in range(30):
            one.add(size * 6.0, 6, 0, 3)
            assert one.disagrees == (disagrees and k >= 19)


def test_the_offset_to_the_others_has_their_common_part_taken_out():
    variance = 1.44
    stationary = [np.diag([variance, variance, 0.09, 1e-4, 1e-4, 1e-3, 0.0, 0.0, 0.0])] * 3
    for share in (0.0, 0.5, 1.0):
        state = SharedState(stationary, share)
        offset, sigma = receiver_offset(state, 1, 3)
        np.testing.assert_array_equal(offset, [0.0, 0.0])
        expected = math.sqrt(variance * (1.0 - share) * 1.5)
        assert sigma == pytest.approx([expected] * 2, abs=1e-6)
    assert np.isnan(receiver_offset(SharedState(stationary[:1], 0.5), 0, 1)[0]).all()


def test_the_offset_has_its_sign_whichever_drone_is_active():
    state = SharedState([np.eye(COUNT)] * 2, 0.0)
    state.joint.mean[:2] = 1.0, 2.0  # drone 0
    for active in (0, 1):
        state.activate(active)
        assert receiver_offset(state, 0, 2)[0] == pytest.approx([1.0, 2.0])
        assert receiver_offset(state, 1, 2)[0] == pytest.approx([-1.0, -2.0])
