# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which detection of the next image is which point, by the picture alone."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from aerial_gnss_ros.core.association.image_links import links
from aerial_gnss_ros.core.association.image_motion import (
    Motion,
    by_motion,
    fitted,
    moved,
)

VARIANCE = 0.01**2
STILL = Motion(np.zeros(6), 0.05**2 * np.eye(6))
POINTS = np.array([[0.0, 0.0], [0.3, 0.1], [-0.2, 0.25]])


def linked(points, found, *, motion=STILL, detected=0.9, density=0.1, possible=None):
    n, m = len(points), len(found)
    able = np.ones((n, m), dtype=bool) if possible is None else possible
    args = np.full(n, VARIANCE), motion, able, np.full(n, detected), density
    return links(np.asarray(points, float), np.asarray(found, float), *args)


def likelihood(points, found, assignment, *, motion=STILL, detected=0.9, density=0.1):
    """The formula of the module, as it stands."""
    hits = [i for i, j in enumerate(assignment) if j >= 0]
    value = detected ** len(hits) * (1.0 - detected) ** (len(points) - len(hits))
    value *= density ** (len(found) - len(hits))
    if hits:
        residuals = found[[assignment[i] for i in hits]] - moved(points[hits], motion)
        by = by_motion(points[hits]).reshape(-1, 6)
        spread = VARIANCE * np.eye(2 * len(hits)) + by @ motion.covariance @ by.T
        value *= multivariate_normal(np.zeros(2 * len(hits)), spread).pdf(residuals.ravel())
    return value


def every(n, m):
    for assignment in itertools.product(range(-1, m), repeat=n):
        taken = [j for j in assignment if j >= 0]
        if len(taken) == len(set(taken)):
            yield assignment


@pytest.mark.parametrize(
    "found",
    [
        [[0.01, 0.01], [0.31, 0.1]],
        [[0.02, 0.0], [0.045, 0.0]],
        [[0.17, 0.05]],
        [[0.3, 0.1], [0.0, 0.0], [0.02, 0.03]],
    ],
)
def test_probabilities_are_those_over_all_assignments(found):
    points, found = np.array([[0.0, 0.0], [0.05, 0.0]]), np.array(found)
    if len(found) == 3:
        points = POINTS[:2]
    chances = np.zeros((len(points), len(found)))
    total = 0.0
    for assignment in every(*chances.shape):
        value = likelihood(points, found, assignment)
        total += value
        for i, j in enumerate(assignment):
            if j >= 0:
                chances[i, j] += value
    assert linked(points, found).chances == pytest.approx(chances / total, abs=1e-4)


def test_what_moves_as_a_whole_is_the_camera():
    """By more than robots lie apart, foretold to a few hundredths: no other assignment fits."""
    shift = np.array([0.3, 0.1])  # the first one comes to lie where the second one was
    motion = Motion(np.array([0.28, 0.12, 0, 0, 0, 0]), 0.05**2 * np.eye(6))
    chances = linked(POINTS, POINTS + shift, motion=motion).chances
    assert chances.diagonal() == pytest.approx(1.0, abs=1e-3)


def test_a_turn_of_the_picture_is_found():
    turn = np.radians(4.0) * np.array([0, 0, 0, -1, 1, 0])
    found = moved(POINTS, Motion(turn, np.zeros((6, 6))))[[2, 0, 1]]
    result = linked(POINTS, found, motion=Motion(np.zeros(6), 0.1**2 * np.eye(6)))
    assert result.chances[[0, 1, 2], [1, 2, 0]] == pytest.approx(1.0, abs=1e-3)
    assert moved(POINTS, result.motion) == pytest.approx(found[[1, 2, 0]], abs=0.005)


def test_two_that_meet_are_not_distinguished():
    """Points half a sigma apart: either way is about as likely."""
    chances = linked([[0.0, 0.0], [0.005, 0.0]], [[0.0, 0.001], [0.005, -0.001]]).chances
    assert 0.4 < chances[0, 0] < 0.7
    assert chances[0, 1] == pytest.approx(1.0 - chances[0, 0], abs=0.02)


def test_images_far_apart_tell_little():
    """Uncertain by their distance, two robots may be either."""
    motion = Motion(np.zeros(6), 0.5**2 * np.eye(6))
    chances = links(
        POINTS[:2], POINTS[:2], np.full(2, 0.3**2), motion, np.ones((2, 2), bool),
        np.full(2, 0.9), 0.1,
    ).chances  # fmt: skip
    assert 0.5 < chances[0, 0] < 0.75


def test_a_detection_out_of_reach_is_of_no_point():
    chances = linked(POINTS[:1], [[0.6, 0.6]]).chances
    assert chances[0, 0] == 0.0


def test_a_point_that_may_not_be_there_yields_its_detection():
    """Of two at one place the one that is certain has it."""
    points = np.zeros((2, 2))
    args = np.full(2, VARIANCE), STILL, np.ones((2, 1), bool)
    chances = links(points, np.zeros((1, 2)), *args, np.array([0.9, 0.09]), 0.1).chances
    odds = 0.9 * (1 - 0.09) / (0.09 * (1 - 0.9))
    assert chances[0, 0] / chances[1, 0] == pytest.approx(odds)


def test_other_classes_are_no_candidates():
    possible = np.array([[False]])
    assert linked(POINTS[:1], POINTS[:1], possible=possible).chances[0, 0] == 0.0


def test_nothing_to_link_is_no_error():
    none = np.zeros((0, 2))
    assert linked(none, POINTS).chances.shape == (0, 3)
    assert linked(POINTS, none).chances.shape == (3, 0)
    assert fitted(none, none, np.zeros(0), STILL).mean == pytest.approx(np.zeros(6))


coordinate = st.floats(-0.6, 0.6, allow_subnormal=False)
places = st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=4).map(np.array)


@settings(max_examples=60, deadline=None)
@given(points=places, found=places, shift=st.tuples(coordinate, coordinate), data=st.data())
def test_probabilities_are_whole_and_order_and_place_do_not_matter(points, found, shift, data):
    chances = linked(points, found).chances
    assert (chances >= 0.0).all()
    assert (chances.sum(axis=0) <= 1.0 + 1e-9).all()
    assert (chances.sum(axis=1) <= 1.0 + 1e-9).all()
    rows = data.draw(st.permutations(range(len(points))))
    columns = data.draw(st.permutations(range(len(found))))
    assert linked(points[rows], found[columns]).chances == pytest.approx(
        chances[np.ix_(rows, columns)], abs=1e-6
    )
    apart = Motion(np.array([*shift, 0, 0, 0, 0]), STILL.covariance)
    assert linked(points, found + shift, motion=apart).chances == pytest.approx(chances, abs=1e-6)
