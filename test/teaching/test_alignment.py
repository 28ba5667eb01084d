# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The motion of the image is found from what floats; without it, from the water, or not."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.teaching.alignment import TUNING, align
from aerial_gnss_ros.teaching.proposals import Proposals

WIDTH = 1280


def _things(rng, count):
    places = rng.uniform((100, 100), (1180, 620), (count, 2))
    looks = rng.dirichlet(np.full(30, 0.3), count)
    return Proposals(np.hstack([places, np.full((count, 2), 30.0)]), looks)


def _seen(things, scale, turn, shift, rng, noise=2.0):
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    places = things.boxes[:, :2] @ np.array([[c, s], [-s, c]]) + shift
    order = rng.permutation(len(places))
    places = places + rng.normal(0.0, noise, places.shape)
    return Proposals(np.hstack([places, things.boxes[:, 2:]])[order], things.looks[order])


@pytest.mark.parametrize("seed", range(8))
def test_a_turn_a_zoom_and_a_shift_are_found(seed):
    """Six things, two of which are new; drawn in any order, off by 2 px."""
    rng = np.random.default_rng(seed)
    things, strange = _things(rng, 6), _things(rng, 2)
    scale, turn = rng.uniform(0.9, 1.1), rng.uniform(-0.25, 0.25)
    shift = rng.uniform(-150.0, 150.0, 2)
    later = _seen(things, scale, turn, shift, rng)
    later = Proposals(
        np.vstack([strange.boxes, later.boxes]), np.vstack([strange.looks, later.looks])
    )
    found = align(things, later, WIDTH)
    assert found.how == "objects"
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    wanted = things.boxes[:, :2] @ np.array([[c, s], [-s, c]]) + shift
    np.testing.assert_allclose(found.move(things.boxes[:, :2]), wanted, atol=8.0)
    np.testing.assert_allclose(
        found.inverse.move(found.move(things.boxes[:, :2])), things.boxes[:, :2], atol=1e-6
    )


def test_things_of_other_colours_align_nothing():
    rng = np.random.default_rng(3)
    found = align(_things(rng, 6), _things(rng, 6), WIDTH)
    assert (found.how, found.sigma) == ("nothing", TUNING.unknown * WIDTH)
    assert found.move(np.array([[5.0, 7.0]])).tolist() == [[5.0, 7.0]]


def test_without_things_the_water_is_correlated():
    rng = np.random.default_rng(4)
    water = rng.normal(0.0, 10.0, (270, 520)).astype(np.float32)
    empty = Proposals(np.zeros((0, 4)), np.zeros((0, 30)))
    smalls = np.ascontiguousarray(water[:, 20:500]), np.ascontiguousarray(water[:, 12:492])
    found = align(empty, empty, WIDTH, smalls)
    assert found.how == "water"
    shift = 8.0 * WIDTH / 480.0
    np.testing.assert_allclose(found.move(np.zeros((1, 2))), [[shift, 0.0]], atol=2.0)
