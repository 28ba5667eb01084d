# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes follow their pixels: an object is drawn, moved as an image, and measured again."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerial_gnss_ros.training import geometry_operations as geometry
from aerial_gnss_ros.training.carrying import carry, rectangle
from aerial_gnss_ros.training.variants import (
    GEOMETRY,
    PIXELS,
    PROBABILITIES,
    Recipe,
    make_variant,
)

WIDTH, HEIGHT = 240, 180
FINE = 4
AXES_STAY = ("flip_horizontal", "flip_vertical", "crop", "pad")

places = st.tuples(
    st.floats(60.0, WIDTH - 60.0), st.floats(50.0, HEIGHT - 50.0), st.floats(16.0, 60.0),
    st.floats(16.0, 60.0),
)  # fmt: skip
seeds = st.integers(0, 2**32)
operations = st.lists(st.sampled_from(list(PROBABILITIES)), unique=True, min_size=1)


def drawn(box, shape):
    """A white object on black; each pixel as bright as the share of it that is covered."""
    x, y, w, h = box
    v, u = (np.mgrid[0 : FINE * HEIGHT, 0 : FINE * WIDTH] + 0.5) / FINE
    dx, dy = np.abs(u - x) / (w / 2), np.abs(v - y) / (h / 2)
    inside = dx**2 + dy**2 <= 1.0 if shape == "ellipse" else np.maximum(dx, dy) <= 1.0
    small = cv2.resize(255.0 * inside, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    return np.repeat(np.rint(small).astype(np.uint8)[..., None], 3, axis=2)


def measured(image):
    """Edges of what is at least half as bright as the brightest pixel, one edge for each side."""
    solid = image[..., 1] >= image[..., 1].max() / 2
    columns, rows = np.flatnonzero(solid.any(axis=0)), np.flatnonzero(solid.any(axis=1))
    return np.array([columns[0], rows[0], columns[-1] + 1, rows[-1] + 1], dtype=float)


def edges(box):
    return np.concatenate([box[:2] - box[2:] / 2, box[:2] + box[2:] / 2])


def variant(box, shape, names, seed, size=(200, 200)):
    recipe = Recipe({name: float(name in names) for name in PROBABILITIES}, size)
    return make_variant(drawn(box, shape), np.array([box]), recipe, np.random.default_rng(seed))


@settings(max_examples=60)
@given(places, operations, seeds)
def test_box_of_an_ellipse_follows_its_pixels(box, names, seed):
    names = set(names) & set(GEOMETRY)
    made = variant(box, "ellipse", names, seed)
    if made is not None:
        np.testing.assert_allclose(measured(made.image), edges(made.boxes[0]), atol=1.0)


@settings(max_examples=30)
@given(places, st.lists(st.sampled_from(AXES_STAY), unique=True, min_size=1), seeds)
def test_box_of_a_rectangle_follows_its_pixels_where_axes_stay_axes(box, names, seed):
    made = variant(box, "rectangle", names, seed)
    if made is not None:
        np.testing.assert_allclose(measured(made.image), edges(made.boxes[0]), atol=1.0)


@settings(max_examples=30)
@given(places, st.sampled_from(list(PIXELS)), seeds)
def test_blur_and_light_leave_the_middle_of_an_object_where_it_is(box, name, seed):
    made = variant(box, "ellipse", {name}, seed, size=(WIDTH, HEIGHT))
    np.testing.assert_allclose(made.boxes[0], box, atol=0.02)
    value = made.image[..., 1].astype(float)
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    middle = np.array([(u * value).sum(), (v * value).sum()]) / value.sum()
    shuffled = name == "glass_blur"  # pixels change places by chance
    np.testing.assert_allclose(middle, box[:2], atol=0.45 if shuffled else 0.3)


def test_a_centre_that_leaves_takes_its_variant_with_it():
    """Two objects further apart than the finished image is wide cannot both stay."""
    boxes = np.array([[20.0, 90.0, 20.0, 20.0], [220.0, 90.0, 20.0, 20.0]])
    image = drawn(boxes[0], "ellipse")
    nothing = dict.fromkeys(PROBABILITIES, 0.0)
    rng = np.random.default_rng(0)
    assert make_variant(image, boxes, Recipe(nothing, (200, 180)), rng) is None
    kept = make_variant(image, boxes, Recipe(nothing, (202, 180)), rng)
    assert kept is not None
    assert kept.image.shape == (180, 202, 3)
    assert (kept.boxes[:, 0] >= 0.0).all()
    assert (kept.boxes[:, 0] < 202.0).all()


def test_a_box_that_is_cut_ends_at_the_edge():
    window = np.array([[1.0, 0.0, -10.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    box = np.array([[12.0, 50.0, 20.0, 30.0]])  # from 2 to 22, of which 10 to 22 is left
    seen = rectangle(100.0, 100.0)
    np.testing.assert_allclose(carry(box, window, seen), [[6.0, 50.0, 12.0, 30.0]], atol=0.02)
    gone = np.array([[1.0, 0.0, -500.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_array_equal(carry(box, gone, seen)[:, 2:], [[0.0, 0.0]])


def test_a_robot_labelled_at_the_edge_keeps_its_box():
    """It shares a piece of the image's border; OpenCV's intersectConvexConvex found nothing."""
    box = np.array([[11.39072, 301.21568, 22.78144, 14.07328]])  # from 0 on
    matrix = np.array(
        [
            [-0.9030360639413187, 0.04046741270812659, 227.31352132847618],
            [0.04468942607467557, 0.7999450359747555, 14.462663223502823],
            [0.0, 0.0, 1.0],
        ]
    )
    border = [
        (227.31352132847618, 14.46266322350282),
        (2.842170943040401e-14, 25.711949063589984),
        (-7.105427357601002e-15, 282.3352086730321),
        (240.2630933950767, 270.4450747354246),
    ]
    whole = carry(box, matrix, rectangle(300.0, 300.0))
    np.testing.assert_allclose(carry(box, matrix, np.array(border)), whole, atol=0.02)
    # Half the axes of the turned ellipse: the roots of (0.903 a)² + (0.040 b)² and so on.
    np.testing.assert_allclose(whole[0, 2:], [20.581, 11.305], atol=0.02)


@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_quarter_turns_are_exact(turns):
    class Chance:
        def integers(self, _):
            return turns

        def uniform(self, *_):
            return 0.0

    matrix, size = geometry.rotation(Chance(), (40, 20), np.zeros((0, 2)))
    assert size == ((40, 20) if turns % 2 == 0 else (20, 40))
    corner = matrix @ np.array([0.0, 0.0, 1.0])
    # Clockwise on the screen: the upper left corner goes to the upper right one, and so on.
    expected = [(0.0, 0.0), (20.0, 0.0), (40.0, 20.0), (0.0, 40.0)][turns]
    np.testing.assert_allclose(corner[:2], expected, atol=1e-9)
