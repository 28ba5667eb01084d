# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Views of boxes: their middle in the middle, as large as asked, without aliasing."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.detection.second_look_terms import Terms, traits
from aerial_gnss_ros.detection.views import turned, views

TERMS = Terms(side=32, near=2.0, wide=4.0, least=16.0)


def ramp(width=256, height=128):
    """Return an image whose blue is its column and whose green is its row."""
    image = np.zeros((height, width, 3), np.uint8)
    image[..., 0], image[..., 1] = np.arange(width), np.arange(height)[:, None]
    return image


@pytest.mark.parametrize("size", [(16.0, 8.0), (40.0, 20.0), (4.0, 4.0)])
def test_a_view_is_centred_on_its_box_and_spans_twice_and_four_times_its_side(size):
    """The near one of a box of 4 px spans 16 px at least, the wide one twice that."""
    u, v = 120.0, 64.0
    (made,) = views(ramp(), np.array([[u, v, *size]]), TERMS)
    assert made.shape == (32, 32, 6)
    near = max(2.0 * max(size), 16.0)
    for first, side in ((0, near), (3, 2.0 * near)):
        blue = made[..., first].astype(float)
        assert blue.mean() == pytest.approx(u, abs=max(1.1, 0.45 * side / 32.0))
        step = (blue[:, 24].mean() - blue[:, 8].mean()) / 16.0
        assert step == pytest.approx(side / 32.0, rel=0.05)
        if side < 100:
            assert made[..., first + 1].mean() == pytest.approx(v, abs=1.1)


def test_beyond_the_edge_the_last_pixels_go_on():
    (made,) = views(ramp(), np.array([[0.0, 64.0, 40.0, 20.0]]), TERMS)
    assert (made[:, :14, 0] <= 1).all()
    assert (np.diff(made[16, :, 0].astype(int)) >= 0).all()


def test_a_large_box_is_shrunk_to_its_mean():
    """Columns that alternate between 0 and 200 become 100, not stripes."""
    stripes = np.zeros((512, 512, 3), np.uint8)
    stripes[:, ::2] = 200
    (made,) = views(stripes, np.array([[255.5, 255.5, 120.0, 120.0]]), TERMS)
    assert np.abs(made.astype(int) - 100).max() <= 12


def test_more_room_shows_more_in_as_many_more_pixels():
    boxes = np.array([[120.0, 64.0, 16.0, 8.0]])
    (made,), (wide,) = views(ramp(), boxes, TERMS), views(ramp(), boxes, TERMS, 1.5)
    assert wide.shape == (48, 48, 6)
    inner = wide[8:40, 8:40].astype(int)
    assert np.abs(inner - made).max() <= 2


def turned_image(image, box, way):
    """Return an image turned by quarters and mirrored, and its box (u, v, width, height)."""
    u, v, wide, tall = box
    for _ in range(way % 4):
        u, v, wide, tall = v, image.shape[1] - 1 - u, tall, wide
        image = np.rot90(image)
    if way >= 4:
        image, u = image[:, ::-1], image.shape[1] - 1 - u
    return np.ascontiguousarray(image), np.array([[u, v, wide, tall]])


@pytest.mark.parametrize("way", range(8))
def test_turned_views_are_those_of_the_turned_image(way):
    image = np.random.default_rng(2).integers(0, 256, (160, 200, 3), dtype=np.uint8)
    box, score = (90.0, 70.0, 32.0, 12.0), np.array([0.4])
    before = np.array([box])
    seen, told = turned(views(image, before, TERMS), traits(before, score), way)
    other, there = turned_image(image, box, way)
    # The middle of a pixel differs by one side of the image and the other: half a pixel of 2.
    wanted = views(other, there, TERMS)
    assert np.abs(seen.astype(int) - wanted).mean() < 1.0
    np.testing.assert_allclose(told, traits(there, score), atol=1e-6)
