# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pictures of a font become things of the wanted size, with their outline and changed colours."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.training.drawings import drawing, pictures_of, recoloured

# A red bar across an otherwise empty picture, with green where nothing covers.
BAR = np.zeros((128, 136, 4), np.uint8)
BAR[..., 1] = 255
BAR[50:80, 8:128] = (0, 0, 255, 255)


def drawn(count, length=40.0, pictures=(BAR,)):
    rng = np.random.default_rng(4)
    return [drawing(rng, length, pictures) for _ in range(count)]


@pytest.mark.parametrize("length", [12.0, 40.0, 100.0])
def test_drawings_have_the_length_and_lie_in_the_middle(length):
    extents, middles, angles = [], [], []
    for share, colours in drawn(60, length):
        assert share.shape == (int(1.5 * length) + 8,) * 2
        assert colours.shape == (*share.shape, 3)
        assert share.dtype == colours.dtype == np.float32
        assert 0.0 <= share.min() <= share.max() <= 1.0
        assert 0.0 <= colours.min() <= colours.max() <= 255.0
        points = np.argwhere(share > 0.4).astype(np.float32)
        if len(points) > 5:
            (_, (a, b), angle) = cv2.minAreaRect(points)
            extents.append(max(a, b))
            angles.append(angle)
            middles.append(points.mean(axis=0) - (len(share) - 1) / 2.0)
    assert 0.75 * length - 1.5 < np.median(extents) < 1.1 * length
    assert max(extents) < 1.15 * length
    assert np.std(angles) > 15.0
    assert np.abs(np.median(middles, axis=0)).max() < 0.06 * length + 0.6


def test_what_covers_nothing_lends_no_colour():
    """Green lies only beyond the outline: where red is exchanged for green, no red comes in."""
    for share, colours in drawn(40):
        inside = colours[share > 0.05]
        spread = np.abs(inside - np.median(inside, axis=0)).max()
        assert spread < 12.0, spread


def test_some_drawings_fade_towards_a_side():
    fading = 0
    for share, _ in drawn(100):
        core = share[share > 0.05]
        fading += float(np.mean(core < 0.8)) > 0.35
    assert 15 < fading < 60


def test_some_drawings_are_parts():
    """Of a ring a part has other proportions: never the hole in its middle."""
    ring = np.zeros((120, 120, 4), np.uint8)
    cv2.circle(ring, (60, 60), 50, (200, 200, 200, 255), 12)
    parts = 0
    for share, _ in drawn(100, 60.0, [ring]):
        side = len(share)
        whole = cv2.connectedComponents((share < 0.02).astype(np.uint8))[0] - 1
        assert side == 98
        parts += whole < 2
    assert 8 < parts < 50


def test_colours_are_exchanged_and_keep_their_edges():
    patches = np.zeros((8, 8, 3), np.float32)
    patches[:, 4:] = (30.0, 60.0, 220.0)
    rng = np.random.default_rng(1)
    brightest, contrasts = set(), []
    for _ in range(60):
        made = recoloured(rng, patches)
        left, right = made[:, :4].reshape(-1, 3), made[:, 4:].reshape(-1, 3)
        assert np.ptp(left, axis=0).max() < 1e-3 > np.ptp(right, axis=0).max()
        if np.ptp(right[0]) > 60.0:
            brightest.add(int(right[0].argmax()))
        contrasts.append(np.abs(left[0] - right[0]).max())
    assert brightest == {0, 1, 2}
    assert min(contrasts) > 20.0
    before = patches.copy()
    recoloured(rng, patches)
    np.testing.assert_array_equal(patches, before)


class _NoFontError(Exception):
    pass


@pytest.fixture
def fonts(monkeypatch):
    """fontTools with one font, `good.ttf`: two pictures, an empty one and one without colour."""

    def png(image):
        return SimpleNamespace(imageData=cv2.imencode(".png", image)[1].tobytes())

    strike = {
        "b": png(BAR), "a": png(BAR[:60]), "grey": png(BAR[..., 0]),
        "none": png(np.zeros((9, 9, 4), np.uint8)), "broken": SimpleNamespace(imageData=b"no"),
    }  # fmt: skip

    def opened(path):
        if path.name == "good.ttf":
            return {"CBDT": SimpleNamespace(strikeData=[strike])}
        if path.name == "plain.ttf":
            return {}
        raise _NoFontError("Not a TrueType font")

    module = SimpleNamespace(TTFont=opened, TTLibError=_NoFontError)
    monkeypatch.setitem(sys.modules, "fontTools", SimpleNamespace(ttLib=module))
    monkeypatch.setitem(sys.modules, "fontTools.ttLib", module)


@pytest.mark.usefixtures("fonts")
def test_a_font_gives_its_coloured_pictures_in_the_order_of_names(tmp_path):
    first, second = pictures_of(tmp_path / "good.ttf")
    np.testing.assert_array_equal(first, BAR[:60])
    np.testing.assert_array_equal(second, BAR)


@pytest.mark.usefixtures("fonts")
@pytest.mark.parametrize("name", ["plain.ttf", "other.txt"])
def test_another_file_is_refused_by_name(tmp_path, name):
    with pytest.raises(InputError, match=name):
        pictures_of(tmp_path / name)
