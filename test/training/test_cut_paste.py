# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots cut out and pasted elsewhere: labels that fit, colours that follow the water."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.training.cut_paste import cut_out, pasted
from aerial_gnss_ros.training.labelled import Truth

WATER = np.array([110.0, 120.0, 70.0])


def _sea(level: float, seed: int = 1) -> np.ndarray:
    noise = np.random.default_rng(seed).normal(0.0, 1.0, (240, 320, 1))
    return np.clip(WATER + level + noise, 0, 255).astype(np.uint8)


def _truth(*corners: tuple[float, ...]) -> Truth:
    count = len(corners)
    kinds = np.arange(count) + 3
    return Truth(
        np.array(corners).reshape(-1, 4), np.ones(count, bool), np.ones(count), np.ones(count),
        kinds,
    )  # fmt: skip


@pytest.fixture(name="robot")
def _robot():
    """A yellow robot of 40 x 16 px, 100 levels over the water in green."""
    image = _sea(0.0)
    cv2.rectangle(image, (100, 80), (139, 95), (60, 220, 200), -1)
    return image, _truth((99.5, 79.5, 139.5, 95.5))


def test_what_is_cut_out_is_the_robot_and_not_its_water(robot):
    (one,) = cut_out(*robot)
    assert one.class_id == 3
    rows, columns = np.nonzero(one.share > 0.5)
    assert np.ptp(rows) + 1 == pytest.approx(16, abs=2)
    assert np.ptp(columns) + 1 == pytest.approx(40, abs=2)
    middle = one.colours[int(rows.mean()), int(columns.mean())]
    np.testing.assert_allclose(middle, np.array([60, 220, 200]) - WATER, atol=3.0)


def test_robots_cut_by_the_edge_and_labels_on_plain_water_are_left(robot):
    image, _ = robot
    assert cut_out(image, _truth((-0.5, 79.5, 39.5, 95.5), (299.0, 80.0, 319.5, 95.0))) == []
    assert len(cut_out(np.full_like(image, 90), _truth((99.5, 79.5, 139.5, 95.5)))) == 0


def test_labels_fit_what_is_pasted_and_its_colours_follow_the_water(robot):
    robots, darker = cut_out(*robot), _sea(-40.0, seed=2)
    there = _truth((10.0, 10.0, 60.0, 60.0))
    total = 0
    for seed in range(12):
        made, truth = pasted(np.random.default_rng(seed), darker, there, robots, 3)
        np.testing.assert_array_equal(truth.corners[0], there.corners[0])
        changed = cv2.absdiff(made, darker).max(axis=2) > 25
        drawn = np.zeros_like(changed)
        for left, top, right, bottom in np.round(truth.corners[1:] + 0.5).astype(int):
            box = changed[top:bottom, left:right]
            assert box[:2].any()
            assert box[-2:].any()
            assert box[:, :2].any()
            assert box[:, -2:].any()
            drawn[top - 1 : bottom + 1, left - 1 : right + 1] = True
        assert not (changed & ~drawn).any()
        assert (made[changed][:, 1] < 210).all()  # 220 over lighter water
        assert made[changed][:, 1].max(initial=200) > 150
        np.testing.assert_array_equal(truth.class_ids[1:], 3)
        low, high = truth.corners[1:, :2], truth.corners[1:, 2:]
        assert ((low > 79.0) | (high < -9.0)).any(axis=1).all()  # 20 px from what is there
        total += len(low)
    assert total > 20


def test_where_there_is_no_room_nothing_is_pasted(robot):
    robots = cut_out(*robot)
    small = _sea(0.0)[:20, :20]
    made, truth = pasted(np.random.default_rng(1), small, _truth(), robots, 5)
    np.testing.assert_array_equal(made, small)
    assert truth.corners.shape == (0, 4)
