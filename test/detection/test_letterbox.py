# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes come back exactly, whatever the sizes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.detection.letterbox import Letterbox

sides = st.integers(1, 5000)


@pytest.mark.parametrize(
    ("source", "longest", "network", "inner"),
    [
        ((1280, 720), 1280, (1280, 736), (1280, 720)),
        ((1920, 1080), 1280, (1280, 736), (1280, 720)),
        ((640, 640), 1280, (640, 640), (640, 640)),
        ((720, 1280), 1280, (736, 1280), (720, 1280)),
        ((320, 200), 1280, (320, 224), (320, 200)),
        ((3840, 2160), 1280, (1280, 736), (1280, 720)),
    ],
)
def test_known_sizes(source, longest, network, inner):
    box = Letterbox.flexible(source, longest)
    assert (box.network, box.inner) == (network, inner)


@given(width=sides, height=sides, longest=st.integers(32, 2000))
def test_free_size_holds_the_image_and_is_made_of_strides(width, height, longest):
    box = Letterbox.flexible((width, height), longest)
    assert all(side % 32 == 0 for side in box.network)
    for source, inner, network, corner in zip(
        box.source, box.inner, box.network, box.corner, strict=True
    ):
        assert inner <= source
        assert 0 <= network - inner < 32
        assert 0 <= corner <= network - inner


@given(width=sides, height=sides)
def test_the_image_s_edges_come_back_as_its_edges(width, height):
    for box in (
        Letterbox.flexible((width, height), 640),
        Letterbox.fixed((width, height), (640, 352)),
    ):
        left, top = box.corner
        edges = np.array([[left, top, left + box.inner[0], top + box.inner[1]]])
        np.testing.assert_allclose(box.to_source(edges), [[0, 0, width, height]], atol=1e-9)


@pytest.mark.parametrize("network", [(640, 640), (1280, 736), (320, 320)])
@pytest.mark.parametrize("size", [(1280, 720), (640, 640), (720, 1280)])
def test_the_picture_lies_where_the_coordinates_say(size, network):
    box = Letterbox.fixed(size, network)
    image = np.zeros((size[1], size[0], 3), np.uint8)
    # A patch whose edges survive any factor used here: multiples of 8 source pixels.
    image[160:320, 80:400] = 255
    fitted = box.apply(image)
    assert fitted.shape == (network[1], network[0], 3)
    v, u = np.nonzero(fitted[..., 0] > 200)
    found = box.to_source(np.array([[u.min(), v.min(), u.max() + 1, v.max() + 1]]))
    np.testing.assert_allclose(found, [[80, 160, 400, 320]], atol=size[0] / network[0] * 0.51)


def test_an_image_that_fits_is_not_copied():
    image = np.zeros((736, 1280, 3), np.uint8)
    assert Letterbox.flexible((1280, 736), 1280).apply(image) is image
