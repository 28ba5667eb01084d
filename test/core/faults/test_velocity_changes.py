# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sums of velocity corrections, and what is expected of them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.faults.manoeuvre_noise import TUNING as MANOEUVRE_NOISE
from aerial_gnss_ros.core.faults.velocity_changes import UnwatchedChanges, VelocityChanges

BOTH = np.arange(2)


def _two(stated=0.0):
    """Return two robots after a step without length, in which velocities became unsure, m²/s²."""
    changes = VelocityChanges()
    changes.add(2)
    changes.predict(0.0, stated)
    return changes


def _note(changes, expected, east=0.0):
    changes.update(BOTH, np.tile([east, 0.0], (2, 1)), np.full(2, expected))


def _variances(changes, unknown=math.inf):
    return changes.variances(BOTH, np.full(2, unknown))


def test_corrections_add_up_and_fade_with_the_time_constant():
    changes = _two()
    changes.update(BOTH[:1], np.array([[0.3, -0.1]]), np.array([0.02]))
    changes.update(BOTH, np.array([[0.2, 0.4], [1.0, 2.0]]), np.array([0.06, 0.5]))
    np.testing.assert_allclose(changes.sums(BOTH), [[0.5, 0.3], [1.0, 2.0]])
    np.testing.assert_allclose(_variances(changes), [0.04, 0.25])  # of both axes, halved
    changes.predict(MANOEUVRE_NOISE.correction_sum_s, 0.0)
    np.testing.assert_allclose(changes.sums(BOTH), np.array([[0.5, 0.3], [1.0, 2.0]]) / math.e)
    np.testing.assert_allclose(_variances(changes), np.array([0.04, 0.25]) / math.e**2)


@pytest.mark.parametrize(
    ("stated", "loosened", "expected", "unknown", "variance"),
    [
        (0.0, 0.0, 0.8, 9.0, 0.4),  # all of it is as stated
        (0.0, 0.5, 0.8, 0.0, 0.0),  # 1.0 m²/s² of both axes explain all, and all is known again
        (0.0, 0.5, 0.8, 0.3, 0.15),  # of which 0.3 m²/s² is not yet
        (0.0, 0.1, 0.8, 0.0, 0.3),  # more than 0.2 m²/s² a loosened velocity does not explain
        (0.1, 0.5, 0.8, 0.0, 0.1),  # what the stated acceleration added is stated
        (0.5, 0.5, 0.8, 0.0, 0.4),  # all of it
    ],
)
def test_a_loosened_velocity_counts_as_far_as_it_is_not_known_again(
    stated, loosened, expected, unknown, variance
):
    changes = _two(stated)
    changes.note_inflation(BOTH[:1], loosened)
    _note(changes, expected)
    assert _variances(changes, unknown)[0] == pytest.approx(variance)
    assert _variances(changes, unknown)[1] == pytest.approx(0.4)


def test_corrections_of_noise_that_is_larger_than_assumed_are_expected_to_be_larger():
    changes = _two()
    changes.note_inflation(BOTH[:1], 0.1)
    _note(changes, 0.8, east=0.3)
    before = _variances(changes)
    changes.discount(9.0)
    np.testing.assert_allclose(_variances(changes), 9.0 * before)
    np.testing.assert_allclose(changes.sums(BOTH), [[0.3, 0.0]] * 2)


def test_what_was_allowed_once_is_not_allowed_again():
    changes = _two()
    changes.note_inflation(BOTH, 0.5)
    for _ in range(2):
        _note(changes, 0.8)
    # 1.0 of 1.6 m²/s² are explained by it.
    assert _variances(changes, 0.0) == pytest.approx(0.5 * 0.6)
    assert _variances(changes) == pytest.approx(0.5 * 1.6)


def test_what_one_turn_explains_is_taken_out():
    changes = _two()
    _note(changes, 0.1, east=0.7)
    changes.explain(BOTH[1:], np.array([[-0.7, 0.2]]))
    np.testing.assert_allclose(changes.sums(BOTH), [[0.7, 0.0], [0.0, 0.2]], atol=1e-12)


def test_a_robot_goes_on_as_another_and_by_what_its_velocity_changed():
    changes = _two()
    changes.update(BOTH[:1], np.array([[0.3, 0.4]]), np.array([0.06]))
    changes.inherit(0, 1, np.array([-0.1, 0.5]), 0.2)
    np.testing.assert_allclose(changes.sums(BOTH[1:]), [[0.2, 0.9]])
    assert changes.variances(BOTH[1:], np.full(1, 9.0)) == pytest.approx(0.5 * (0.06 + 0.2))
    # What is not known of its velocity is still to come, once.
    changes.update(BOTH[1:], np.zeros((1, 2)), np.array([0.25]))
    assert changes.variances(BOTH[1:], np.zeros(1)) == pytest.approx(0.5 * (0.06 + 0.05))


def test_a_robot_that_is_copied_from_another_law_brings_its_sums():
    source, target = _two(), _two()
    source.update(BOTH, np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([0.1, 0.2]))
    target.add(1)
    target.copy(source, 0)
    np.testing.assert_array_equal(target.sums(np.arange(3)), [[0, 0], [0, 0], [1, 2]])
    target.drop(np.array([False, False, True]))
    np.testing.assert_array_equal(target.sums(BOTH[:1]), [[1.0, 2.0]])
    assert len(target.position_covariances) == len(target.velocity_covariances) == 1


def test_a_robot_that_an_image_does_not_show_is_no_surer_for_it():
    changes, less, more = _two(), np.tile(np.eye(2), (2, 1, 1)), 4.0 * np.tile(np.eye(2), (2, 1, 1))
    changes.widen(BOTH[:1], more[:1], more[:1], seen=True)
    changes.widen(BOTH, less, 2.0 * less, seen=False)
    assert changes.position_covariances[:, 0, 0].tolist() == [4.0, 1.0]
    assert changes.velocity_covariances[:, 0, 0].tolist() == [4.0, 2.0]
    changes.widen(BOTH, less, 2.0 * less, seen=True)
    assert changes.position_covariances[:, 0, 0].tolist() == [1.0, 1.0]
    assert changes.velocity_covariances[:, 1, 1].tolist() == [2.0, 2.0]


def test_of_robots_that_are_not_watched_nothing_is_kept():
    changes = UnwatchedChanges()
    changes.add(2)
    changes.predict(0.1, 0.0)
    changes.update(BOTH, np.ones((2, 2)), np.ones(2))
    changes.note_inflation(BOTH, 0.5)
    changes.inherit(0, 1, np.array([-0.1, 0.5]), 0.2)
    changes.copy(_two(), 0)
    changes.drop(np.array([True, False]))
    assert not len(changes.position_covariances)
