# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where robots out of sight may be, with numbers that can be checked by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.identity.return_position import (
    ReturnPosition,
    VelocityLikelihood,
    _reduced,
)
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.values.estimates import State

MOTION = MotionModel(0.05, 0.75)
GONE_S = 10.0
VELOCITY = np.array([0.5, 0.0])
STRAIGHT = 0.25 / (2.0 * np.pi * (0.3 * 0.5 * GONE_S) ** 2)
"""A quarter of robots go straight on, off by 0.3 of their way; where this leads, 1/m²."""


def _coasted():
    """Return reach, s, and variance of a robot whose place and velocity were known, by images."""
    state, spread, unseen = np.array([0.0, 1.0]), np.zeros((2, 2)), 0.0
    for _ in range(round(GONE_S / 0.1)):
        reach, kept, noise = MOTION.step(0.1, np.array([unseen]))
        step = np.array([[1.0, reach[0]], [0.0, 1.0 if kept is None else kept[0]]])
        pp, pv, vv = noise[0]
        state, spread = step @ state, step @ spread @ step.T + [[pp, pv], [pv, vv]]
        unseen += 0.1
    return float(state[0]), float(spread[0, 0])


def _density(place, swims):
    """Return the density at a place relative to that where a robot went down, m."""
    reach, variance = _coasted()
    last = State.COASTING, "aqua_1", (0,)
    track = Track(
        "aqua", 0, 0, *last, velocity=VELOCITY, speed_history=0.4, speed_history_count=3.0
    )
    offsets = (np.array(place) - reach * VELOCITY)[None]
    spread = (variance * np.eye(2))[None]
    return float(ReturnPosition(MOTION).density(track, GONE_S, offsets, spread, swims)[0])


def _seen(velocity, sigma=0.05):
    return VelocityLikelihood(np.array([velocity], float), sigma**2 * np.eye(2)[None])


UNSEEN = _seen((0.0, 0.0), 100.0)


def test_a_robot_that_went_straight_on_is_expected_there():
    """Between images as in one step: else it would be sought elsewhere, and farther about."""
    assert STRAIGHT < _density((5.0, 0.0), UNSEEN) < 1.3 * STRAIGHT


@pytest.mark.parametrize(
    ("place", "likely", "unlikely"),
    [
        ((5.0, 0.0), (0.5, 0.0), (-0.5, 0.0)),
        ((5.0, 1.5), (0.5, 0.3), (0.5, -0.3)),  # it has turned, and that a while ago
    ],
)
def test_how_it_swims_tells_whether_it_went_straight_on(place, likely, unlikely):
    rare, usual, often = (
        _density(place, swims) for swims in (_seen(unlikely), UNSEEN, _seen(likely))
    )
    assert rare < usual < often
    assert often > 3.0 * rare


def test_what_boxes_alone_say_of_a_velocity():
    """0.4 m/s measured with 0.3 m/s, put together with 0 at 0.75 m/s; and one not seen at all."""
    prior, box = 0.75**2, 0.3**2
    left = prior * box / (prior + box)
    found = VelocityLikelihood.of(
        np.array([[left / box * 0.4, 0.0], [0.0, 0.0]]),
        np.array([left, prior])[:, None, None] * np.eye(2),
        0.75,
    )
    assert found.velocities[0] == pytest.approx([0.4, 0.0])
    assert found.spread[0] == pytest.approx(box * np.eye(2))
    reported = found.ratio(np.array([0.4, 0.0]), 0.01 * np.eye(2), 0.75)
    assert reported[0] > 2.0
    assert reported[1] == pytest.approx(1.0, abs=1e-3)


def test_a_robot_never_seen_swims_as_the_others_do():
    """One used to 0.2 m/s, with one at 0.75 m/s supposed: variance 0.05 m²/s², its own 0.0025.

    A slow track then is no sign that it is one of those that are known.
    """
    slow = Track(
        "aqua",
        0,
        0,
        State.COASTING,
        "aqua_1",
        (0,),
        speed_history=1.9875,
        speed_history_count=50.0,
    )
    found = ReturnPosition(MOTION).new_robot_density(
        [slow], np.full((1, 1, 2), 1e3), 60.0, _seen((0.1, 0.1))
    )
    expected = 0.565 / 0.0525 * np.exp(-0.5 * 0.02 * (1 / 0.0525 - 1 / 0.565))
    assert 2.0 * 60.0**2 * found == pytest.approx([expected])


def test_a_robot_never_seen_comes_up_amid_the_others():
    """60 m of water have a variance of 300 m²; three at 0, 3 and -3 m east add 18 m² there."""
    three = [Track("aqua", 0, 0, State.COASTING, f"aqua_{i}", (0,)) for i in range(3)]
    places = np.array([[0.0, 0.0], [3.0, 0.0], [-3.0, 0.0]])
    offsets = np.array([[0.0, 5.0], [0.0, 1000.0]]) - places[:, None]
    unseen = VelocityLikelihood(np.zeros((2, 2)), 1e9 * np.tile(np.eye(2), (2, 1, 1)))
    near, far = ReturnPosition(MOTION).new_robot_density(three, offsets, 60.0, unseen)
    amid = np.exp(-0.5 * 25.0 / 100.0) / (2.0 * np.pi * np.sqrt(106.0 * 100.0))
    assert near == pytest.approx(0.5 / 3600.0 + 0.5 * amid, rel=1e-3)
    assert far == pytest.approx(0.5 / 3600.0, rel=1e-3)


def test_position_and_velocity_of_a_robot_that_went_straight_on_are_correlated():
    """Against one Gaussian of both, over the prior of the velocity.

    Deflection by 0.3 of the way at 0.75 m/s: in position off = (0.3 * 0.75 t)², in velocity
    3 off / t², between them 1.5 off / t. The velocity was known to 0.2 m/s, which t s have carried
    into the position.
    """
    t, known, base, measured = GONE_S, 0.2**2, 0.5, 0.1**2
    off = (0.3 * 0.75 * t) ** 2
    track = Track(
        "aqua", 0, 0, State.COASTING, "aqua_1", velocity=VELOCITY, velocity_spread=known * np.eye(2)
    )
    ahead, velocity = np.array([2.0, -1.0]), np.array([0.7, -0.2])
    spread = (base + t**2 * known) * np.eye(2)
    found = ReturnPosition(MOTION)._straight(
        track, t, ahead[None], spread[None], _seen(velocity, np.sqrt(measured))
    )
    place, between = base + t**2 * known + off, 1.5 * off / t + t * known
    moving = 3.0 * off / t**2 + MOTION.acceleration**2 * t + known + measured
    both = np.kron([[place, between], [between, moving]], np.eye(2))
    density = multivariate_normal(np.zeros(4), both).pdf([*ahead, *(velocity - VELOCITY)])
    prior = multivariate_normal(np.zeros(2), measured + MOTION.speed_sigma**2).pdf(velocity)
    assert found == pytest.approx([density / prior])


def test_covariances_less_what_the_model_adds_stay_positive_definite():
    turned = np.array([[0.8, -0.6], [0.6, 0.8]])
    spread = turned @ np.diag([4.0, 1.0]) @ turned.T
    for variance, left in ((0.4, [0.6, 3.6]), (5.0, [1e-3, 3.001])):
        found = _reduced(spread[None], variance)[0]
        assert np.linalg.eigvalsh(found) == pytest.approx(left)
        assert found @ turned == pytest.approx(turned * left[::-1])
