# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Several joint Gaussians at once, against one dense Kalman filter for each."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.bank_state import COMMON, OWN, BankState, ShownPlaces
from aerial_gnss_ros.core.filter.state import TUNING as STATE

COUNT, GAUSSIAN, SPEED = 3, 1e9, 0.5


def random(seed):
    return np.random.default_rng(seed)


def platform(rng):
    roots = rng.normal(size=(COUNT, 6, 6))
    return roots @ roots.swapaxes(1, 2)


def shown(rng):
    """Return where a box shows its robot, somehow."""
    return ShownPlaces(
        rng.normal(size=(COUNT, 2)), rng.normal(size=(COUNT, 2, COMMON)),
        rng.normal(size=(COUNT, 2, 2)), rng.uniform(0.5, 2.0, COUNT), np.ones(COUNT, bool),
    )  # fmt: skip


def state(rng, robots=2):
    """Return a state with robots whose errors are correlated with all others'."""
    found = BankState(platform(rng), SPEED)
    found.begin_image(rng.uniform(0.5, 2.0, (COUNT, 6)), np.zeros(COUNT), np.ones(COUNT))
    for _ in range(robots):
        found.add(shown(rng))
    found.predict(0.7, np.full(COUNT, 0.9), platform(rng), np.full(COUNT, 0.3))
    return found


def measurement(rng, slot, size):
    """Return derivatives by the common errors and the place, and the whole row (c, 2, size)."""
    common, place = rng.normal(size=(COUNT, 2, COMMON)), rng.normal(size=(COUNT, 2, 2))
    row, first = np.zeros((COUNT, 2, size)), COMMON + OWN * slot
    row[:, :, :COMMON], row[:, :, first : first + 2] = common, place
    row[:, :, first + 4 : first + 6] = np.eye(2)
    return common, place, row


def test_a_robot_begins_where_its_box_shows_it_with_all_errors_of_that():
    rng = random(1)
    found, box = BankState(platform(rng), SPEED), shown(rng)
    found.begin_image(np.ones((COUNT, 6)), np.zeros(COUNT), np.ones(COUNT))
    before = found.covariance.copy()
    found.add(box)
    by = np.zeros((COUNT, 2, COMMON + OWN))  # what the place is off by: common errors, less the box
    by[:, :, :COMMON] = box.by_common
    by[:, :, COMMON + 4 :] = -box.by_box
    all_errors = np.zeros((COUNT, COMMON + OWN, COMMON + OWN))
    all_errors[:, :COMMON, :COMMON] = before
    all_errors[:, COMMON + 4 :, COMMON + 4 :] = box.box_variance[:, None, None] * np.eye(2)
    places = found.covariance[:, COMMON : COMMON + 2]
    np.testing.assert_allclose(
        places[:, :, COMMON : COMMON + 2], by @ all_errors @ by.swapaxes(1, 2)
    )
    np.testing.assert_allclose(places[:, :, :COMMON], (by @ all_errors)[:, :, :COMMON])
    np.testing.assert_allclose(places[:, :, COMMON + 4 :], (by @ all_errors)[:, :, COMMON + 4 :])
    speeds = found.covariance[:, [COMMON + 2, COMMON + 3], [COMMON + 2, COMMON + 3]]
    np.testing.assert_allclose(speeds, SPEED**2)
    np.testing.assert_array_equal(found.robots[:, 0, :2], box.places)


def test_prediction_is_that_of_a_dense_filter():
    rng = random(2)
    found, stationary = state(rng), platform(rng)
    found.mean = rng.normal(size=found.mean.shape)
    keep, seconds, acceleration = np.array([0.0, 0.5, 0.9]), 0.8, np.array([0.0, 0.2, 0.5])
    step = np.tile(np.eye(found.mean.shape[1]), (COUNT, 1, 1))
    noise = np.zeros_like(step)
    step[:, range(6), range(6)] = keep[:, None]
    noise[:, :6, :6] = (1.0 - keep**2)[:, None, None] * stationary
    for slot in (0, 1):
        for a in (COMMON + OWN * slot, COMMON + OWN * slot + 1):
            step[:, a, a + 2] = seconds
            q = (acceleration**2)[:, None, None] * np.array(
                [[seconds**3 / 3, seconds**2 / 2], [seconds**2 / 2, seconds]]
            )
            noise[:, [[a], [a + 2]], [[a, a + 2]]] += q
    mean = (step @ found.mean[..., None])[..., 0]
    covariance = step @ found.covariance @ step.swapaxes(1, 2) + noise
    found.predict(seconds, keep, stationary, acceleration)
    np.testing.assert_allclose(found.mean, mean)
    np.testing.assert_allclose(found.covariance, covariance, atol=1e-12)


def test_a_new_image_has_its_own_noise_and_boxes_errors_that_last_in_part():
    rng = random(3)
    found = state(rng)
    found.mean = rng.normal(size=found.mean.shape)
    before, keep = found.covariance.copy(), np.array([0.0, 0.4, 1.0])
    white, box = rng.uniform(1.0, 2.0, (COUNT, 6)), np.array([1.0, 2.0, 3.0])
    found.begin_image(white, keep, box)
    np.testing.assert_allclose(found.covariance[:, range(6, 12), range(6, 12)], white)
    np.testing.assert_array_equal(found.covariance[:, 6:12, COMMON:], 0.0)
    np.testing.assert_array_equal(found.mean[:, 6:12], 0.0)
    a = COMMON + OWN + 5
    expected = keep**2 * before[:, a, a] + (1.0 - keep**2) * box
    np.testing.assert_allclose(found.covariance[:, a, a], expected)
    np.testing.assert_allclose(found.covariance[:, a, 0], keep * before[:, a, 0])
    np.testing.assert_allclose(found.covariance[:, 0, COMMON], before[:, 0, COMMON])


def test_boxes_one_after_the_other_tell_what_they_tell_together():
    """Dense Kalman filter with both boxes in one measurement."""
    rng = random(4)
    found = state(rng)
    size, noise = found.mean.shape[1], rng.uniform(0.1, 0.3, COUNT)
    both, mean, covariance = (
        rng.normal(size=(COUNT, 2, 2)),
        found.mean.copy(),
        found.covariance.copy(),
    )
    common, place, rows = zip(*(measurement(rng, slot, size) for slot in (0, 1)), strict=True)
    given = np.stack(common, axis=1), np.stack(place, axis=1), noise, GAUSSIAN
    fit = found.correct([0, 1], both, np.ones((COUNT, 2), bool), *given)
    spread = rows[0] @ covariance @ rows[0].swapaxes(1, 2) + noise[:, None, None] * np.eye(2)
    np.testing.assert_allclose(fit.determinants[:, 0], np.linalg.det(spread))
    told = np.linalg.solve(spread, both[:, 0, :, None])[..., 0]
    np.testing.assert_allclose(fit.squared[:, 0], np.sum(told * both[:, 0], axis=1))
    row = np.concatenate(rows, axis=1)
    spread = row @ covariance @ row.swapaxes(1, 2) + noise[:, None, None] * np.eye(4)
    gain = covariance @ row.swapaxes(1, 2) @ np.linalg.inv(spread)
    residual = both.reshape(COUNT, 4, 1)
    np.testing.assert_allclose(found.mean, mean + (gain @ residual)[..., 0], atol=1e-9)
    np.testing.assert_allclose(found.covariance, covariance - gain @ row @ covariance, atol=1e-9)
    sizes = fit.determinants.prod(axis=1)
    np.testing.assert_allclose(sizes, np.linalg.det(spread))
    squared = (residual.swapaxes(1, 2) @ np.linalg.solve(spread, residual))[:, 0, 0]
    np.testing.assert_allclose(fit.squared.sum(axis=1), squared)


def test_a_box_that_is_not_compared_takes_no_part_by_its_residual():
    """It counts as if it were where it is expected, whatever the box before it tells."""
    moved = []
    for seen in (True, False):
        rng = random(11)
        found = state(rng)
        size, residuals = found.mean.shape[1], rng.normal(size=(COUNT, 2, 2))
        common, place, _ = zip(*(measurement(rng, slot, size) for slot in (0, 1)), strict=True)
        before = found.mean.copy()
        given = np.stack(common, axis=1), np.stack(place, axis=1), np.ones(COUNT), GAUSSIAN
        fit = found.correct([0, 1], residuals, np.array([[True, seen]] * COUNT), *given)
        moved.append(found.mean - before)
    assert (fit.squared[:, 1] == 0.0).all()
    alone = state(random(11))
    given = common[0][:, None], place[0][:, None], np.ones(COUNT), GAUSSIAN
    alone.correct([0], residuals[:, :1], np.ones((COUNT, 1), bool), *given)
    np.testing.assert_allclose(moved[1], alone.mean - before, atol=1e-12)
    assert not np.allclose(moved[0], moved[1])


@pytest.mark.parametrize("size", [0.5, 20.0])
def test_a_box_that_fits_badly_counts_less(size):
    """By (ν + 2) / (ν + q), and never more than a Gaussian's."""
    moved = []
    for degrees in (4.0, GAUSSIAN):
        rng = random(5)
        found = state(rng)
        common, place, _ = measurement(rng, 0, found.mean.shape[1])
        residual = np.full((COUNT, 1, 2), size)
        before, seen = found.mean.copy(), np.ones((COUNT, 1), bool)
        given = common[:, None], place[:, None], np.ones(COUNT), degrees
        fit = found.correct([0], residual, seen, *given)
        moved.append(found.mean - before)
    weight = np.minimum(6.0 / (4.0 + fit.squared[:, 0]), 1.0)
    np.testing.assert_allclose(moved[0], weight[:, None] * moved[1], atol=1e-12)
    assert (weight < 1.0).all() or size < 1.0


def test_robots_that_are_kept_come_into_the_order_asked_for():
    found = state(random(6), robots=3)
    before = found.covariance.copy()
    found.keep([2, 0])
    columns = [*range(COMMON), *range(COMMON + 12, COMMON + 18), *range(COMMON, COMMON + 6)]
    np.testing.assert_array_equal(found.covariance, before[:, columns][:, :, columns])
    assert found.robots.shape[1] == 2


def test_a_robot_begins_anew_in_some_gaussians_only():
    rng = random(7)
    found, box = state(rng), shown(rng)
    mean, covariance = found.mean.copy(), found.covariance.copy()
    found.restart(1, box, np.array([True, False, False]))
    np.testing.assert_array_equal(found.mean[1:], mean[1:])
    np.testing.assert_array_equal(found.covariance[1:], covariance[1:])
    np.testing.assert_array_equal(found.mean[0, : COMMON + OWN], mean[0, : COMMON + OWN])
    alone = BankState(covariance[:, :6, :6], SPEED)
    alone.mean, alone.covariance = mean[:, :COMMON].copy(), covariance[:, :COMMON, :COMMON].copy()
    alone.add(box)
    own = slice(COMMON + OWN, COMMON + 2 * OWN)
    np.testing.assert_allclose(found.mean[0, own], alone.mean[0, COMMON:])
    np.testing.assert_allclose(found.covariance[0, own, own], alone.covariance[0, COMMON:, COMMON:])


def test_what_is_forgotten_is_as_unknown_as_at_first():
    rng = random(8)
    found, stationary = state(rng), platform(rng)
    found.mean = rng.normal(size=found.mean.shape)
    before = found.covariance.copy()
    found.forget(np.array([False, True, False]), stationary)
    np.testing.assert_array_equal(found.covariance[[0, 2]], before[[0, 2]])
    np.testing.assert_array_equal(found.covariance[1, :6, :6], stationary[1])
    np.testing.assert_array_equal(found.covariance[1, :6, 6:], 0.0)
    np.testing.assert_array_equal(found.mean[1, :6], 0.0)
    assert found.covariance[1, COMMON, COMMON] == STATE.wide_m**2


def test_rounding_is_taken_out():
    found = state(random(9))
    found.covariance[0, 1, 0] += 1e-6
    found.symmetrise()
    np.testing.assert_array_equal(found.covariance, found.covariance.swapaxes(1, 2))
