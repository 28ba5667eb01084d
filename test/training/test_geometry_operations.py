# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where operations take points: matrices against what their names say."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.training import geometry_operations as geometry

SIZE = (240, 180)
CORNERS = np.array([[0.0, 240.0, 240.0, 0.0], [0.0, 0.0, 180.0, 180.0], [1.0] * 4])
seeds = st.integers(0, 2**32)


def operated(name, seed, centres=()):
    """Return where the corners go (2, 4), and the new size."""
    rng, places = np.random.default_rng(seed), np.array(centres).reshape(-1, 2)
    matrix, size = getattr(geometry, name)(rng, SIZE, places)
    return (matrix @ CORNERS)[:2], size


@pytest.mark.parametrize(
    ("name", "places"),
    [
        ("flip_horizontal", [[240.0, 0.0, 0.0, 240.0], [0.0, 0.0, 180.0, 180.0]]),
        ("flip_vertical", [[0.0, 240.0, 240.0, 0.0], [180.0, 180.0, 0.0, 0.0]]),
    ],
)
def test_a_flip_swaps_two_sides(name, places):
    found, size = operated(name, 0)
    assert found.tolist() == places
    assert size == SIZE


@given(seeds)
def test_a_rotation_turns_about_the_middle_and_keeps_lengths(seed):
    found, size = operated("rotation", seed)
    assert size in (SIZE, SIZE[::-1])
    assert found.mean(axis=1) == pytest.approx([size[0] / 2, size[1] / 2])
    sides = np.hypot(*(np.roll(found, -1, axis=1) - found))
    assert sides == pytest.approx([240.0, 180.0, 240.0, 180.0])
    edge = found[:, 1] - found[:, 0]
    angle = np.degrees(np.arctan2(edge[1], edge[0]))
    off = (angle + 45.0) % 90.0 - 45.0
    assert abs(off) <= geometry.TILT_DEG
    assert (size == SIZE) == (abs(np.round((angle - off) / 90.0)) % 2 == 0)


@given(seeds)
def test_a_pad_adds_to_each_side_and_a_crop_takes(seed):
    found, size = operated("pad", seed)
    for axis in (0, 1):
        most = round(geometry.MOST_PAD * SIZE[axis])
        assert 0 <= found[axis, 0] <= most
        assert 0 <= size[axis] - found[axis, 2] <= most
    found, size = operated("crop", seed)
    for axis in (0, 1):
        assert size[axis] >= round(geometry.LEAST_CROP * SIZE[axis])
        assert found[axis, 0] <= 0
        assert found[axis, 2] >= size[axis]


@given(seeds, st.tuples(st.floats(0.0, 239.9), st.floats(0.0, 179.9)))
def test_a_crop_keeps_the_middle_of_a_box(seed, centre):
    rng = np.random.default_rng(seed)
    matrix, size = geometry.crop_to(rng, SIZE, np.array([centre]), (100, 500))
    assert size == (100, 180)
    place = matrix @ [*centre, 1.0]
    assert 0.0 <= place[0] < 100.0
    assert place[1] == centre[1]


@given(seeds)
def test_an_affine_map_is_within_its_bounds(seed):
    found, size = operated("affine", seed)
    assert size == SIZE
    shift = found.mean(axis=1) - [120.0, 90.0]
    assert (np.abs(shift) <= geometry.TRANSLATE * np.array(SIZE) + 1e-9).all()
    across, down = (found[:, 1] - found[:, 0]) / 240.0, (found[:, 2] - found[:, 1]) / 180.0
    shear = np.tan(np.radians(geometry.SHEAR_DEG))
    assert max(abs(across[1]), abs(down[0])) <= shear + 1e-9
    assert min(across[0], down[1]) >= geometry.SCALE**-1.3
    assert max(across[0], down[1]) <= geometry.SCALE**1.3
