# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Known positions correct the receiver's offset and all robots, each as it hangs together."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.references.position_law import (
    PlatformKnowledge,
    PositionLaw,
    blocks_apart,
)

GNSS_M, OWN_M = 1.2, 0.1
TOLD = 0.05


def law(count=3):
    """Robots that only the receiver's offset displaces together, each with an error of its own."""
    platform = np.diag([GNSS_M**2, GNSS_M**2, 0.1, 0.01, 0.01, 0.01, 0.0, 0.0, 0.0])
    joint = JointState(platform)
    by_platform = np.zeros((count, 2, COUNT))
    by_platform[:, 0, 0] = by_platform[:, 1, 1] = 1.0
    places = np.arange(2.0 * count).reshape(count, 2)
    white = np.tile(OWN_M**2 * np.eye(2), (count, 1, 1))
    joint.add(np.arange(count) + 5, places, by_platform, white, 0.5)
    return PositionLaw.of(joint)


def test_one_known_robot_corrects_the_offset_and_the_others():
    before = law()
    off = np.array([1.5, -0.8])
    position = before.mean[before.places([6])] + off
    after = before.known([6], position[None], TOLD**2 * np.eye(2)[None])
    gain = GNSS_M**2 / (GNSS_M**2 + OWN_M**2 + TOLD**2)
    assert after.offset()[0] == pytest.approx(gain * off)
    assert after.offset()[1] == pytest.approx((1.0 - gain) * GNSS_M**2 * np.eye(2))
    states, blocks = after.states()
    assert states[0, :2] - before.states()[0][0, :2] == pytest.approx(gain * off)
    # another robot is as certain as the way over the known one, a little more by the prior
    expected = OWN_M**2 + (1.0 - gain) * GNSS_M**2
    assert blocks[2, :2, :2] == pytest.approx(expected * np.eye(2))
    assert blocks[1, 0, 0] < TOLD**2


def test_all_is_as_the_formula_of_a_conditional_normal_law_says():
    rng = np.random.default_rng(3)
    root = rng.standard_normal((COUNT + 12, COUNT + 12))
    whole = PositionLaw(np.array([4, 9, 2]), rng.standard_normal(COUNT + 12), root @ root.T)
    reported, spread = rng.standard_normal((2, 2)), np.array([[[0.3, 0.1], [0.1, 0.2]], np.eye(2)])
    found = whole.known([2, 4], reported, spread)
    own = [COUNT + 8, COUNT + 9, COUNT, COUNT + 1]
    noise = np.zeros((4, 4))
    noise[:2, :2], noise[2:, 2:] = spread
    H = np.eye(COUNT + 12)[own]
    K = whole.covariance @ H.T @ np.linalg.inv(H @ whole.covariance @ H.T + noise)
    assert found.mean == pytest.approx(whole.mean + K @ (reported.ravel() - H @ whole.mean))
    assert found.covariance == pytest.approx(whole.covariance - K @ H @ whole.covariance)
    assert blocks_apart(spread) == pytest.approx(noise)


def test_what_a_known_robot_tells_of_the_platform_corrects_the_others_alike():
    before, off = law(), np.array([1.5, -0.8])
    position = (before.mean[before.places([6])] + off)[None]
    spread = TOLD**2 * np.eye(2)[None]
    reported = before.knowledge([6], position, spread)
    assert reported.by_errors[:, :2] == pytest.approx(np.eye(2))
    assert reported.value == pytest.approx(off)
    assert reported.spread == pytest.approx((OWN_M**2 + TOLD**2) * np.eye(2), rel=1e-4)
    direct, after = before.known([6], position, spread), before.given(reported)
    assert after.offset()[0] == pytest.approx(direct.offset()[0])
    assert after.offset()[1] == pytest.approx(direct.offset()[1], rel=1e-4)
    assert after.states()[0][[0, 2]] == pytest.approx(direct.states()[0][[0, 2]])
    assert after.states()[1][[0, 2]] == pytest.approx(direct.states()[1][[0, 2]], rel=1e-4)


@pytest.mark.parametrize("keeps", [(0.9, 0.9), (0.9, 0.6), (1.0, 0.0), (0.0, 0.0)])
def test_knowledge_of_errors_ages_as_each_of_them_drifts(keeps):
    """Exactly: what a sum of two receivers' offsets told of both is carried on as they drift."""
    keep, prior = np.repeat(keeps, COUNT), np.diag(np.repeat([1.44, 4.0], COUNT))
    H = np.zeros((2, 2 * COUNT))
    H[:, :2] = H[:, COUNT : COUNT + 2] = np.eye(2)
    value, R = np.array([1.5, -0.8]), 0.05 * np.eye(2)
    gain = prior @ H.T @ np.linalg.inv(H @ prior @ H.T + R)
    then = prior - gain @ H @ prior
    expected = keep[:, None] * then * keep + (1.0 - np.outer(keep, keep)) * prior
    nobody = PositionLaw(np.zeros(0, np.intp), np.zeros(2 * COUNT), prior)
    found = nobody.given(PlatformKnowledge(H, value, R).later(keep, prior))
    assert found.mean == pytest.approx(keep * (gain @ value))
    assert found.covariance == pytest.approx(expected)


def test_a_receiver_without_error_is_not_corrected():
    exact = law()
    exact.covariance[:2] = exact.covariance[:, :2] = 0.0
    after = exact.given(exact.knowledge([6], np.array([[9.0, 9.0]]), np.eye(2)[None]))
    assert after.offset()[0] == pytest.approx(np.zeros(2))
    assert np.isfinite(after.mean).all()


def test_with_several_drones_the_errors_of_all_come_first():
    rng = np.random.default_rng(5)
    root = rng.standard_normal((2 * COUNT + 8, 2 * COUNT + 8))
    both = PositionLaw(np.array([3, 8]), rng.standard_normal(2 * COUNT + 8), root @ root.T)
    assert both.errors == 2 * COUNT
    assert both.receivers.tolist() == [0, 1, COUNT, COUNT + 1]
    assert both.offset(1)[0] == pytest.approx(both.mean[COUNT : COUNT + 2])
    assert both.offset(1)[1] == pytest.approx(both.covariance[COUNT : COUNT + 2, COUNT : COUNT + 2])
    assert both.places([8, 3]).tolist() == [2 * COUNT + k for k in (4, 5, 0, 1)]
    known = [3], np.array([[2.0, -1.0]]), np.array([[[0.3, 0.1], [0.1, 0.2]]])
    direct, reported = both.known(*known), both.knowledge(*known)
    after = both.given(reported)
    assert after.mean[: 2 * COUNT] == pytest.approx(direct.mean[: 2 * COUNT])
    assert after.covariance[:14, :14] == pytest.approx(direct.covariance[:14, :14], rel=1e-4)
