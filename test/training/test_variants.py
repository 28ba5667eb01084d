# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Operations do what their names say; light of a temperature has the right colour."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.training import pixel_operations as pixels
from aerial_gnss_ros.training.colour import chromaticity, gains, table
from aerial_gnss_ros.training.variants import PROBABILITIES, Recipe, make_variant


# A black body's chromaticity: CIE 15 for illuminant A, G. Wyszecki and W. S. Stiles, Color Science
# (1982), table 1(3.11), for the others.
@pytest.mark.parametrize(
    ("kelvin", "x", "y"),
    [
        (2856.0, 0.4476, 0.4074),
        (4000.0, 0.3805, 0.3768),
        (5000.0, 0.3451, 0.3516),
        (6500.0, 0.3135, 0.3237),
        (10000.0, 0.2807, 0.2884),
    ],
)
def test_chromaticity_of_a_black_body(kelvin, x, y):
    np.testing.assert_allclose(chromaticity(kelvin), (x, y), atol=1e-3)  # of the approximation


def test_warm_light_is_red_and_cold_light_blue():
    blue, _, red = gains(4000.0)
    assert red > 1.1
    assert blue < 0.75
    blue, _, red = gains(20000.0)
    assert red < 0.9
    assert blue > 1.3
    np.testing.assert_array_equal(table(6500.0), np.repeat(np.arange(256)[:, None], 3, axis=1))


def scene():
    rng = np.random.default_rng(3)
    return cv2.resize(rng.integers(0, 256, (40, 60, 3), dtype=np.uint8), (240, 160))


@pytest.mark.parametrize("name", ["motion_blur", "gaussian_blur"])
def test_blur_takes_detail_and_keeps_brightness(name):
    rng = np.random.default_rng(0)
    before = scene()
    for _ in range(20):
        after = getattr(pixels, name)(rng, before)
        assert after.shape == before.shape
        assert abs(after.mean() - before.mean()) < 1.0
        assert cv2.Laplacian(after, cv2.CV_64F).var() < cv2.Laplacian(before, cv2.CV_64F).var()


def test_glass_blur_mixes_neighbours_and_nothing_further_away():
    rng = np.random.default_rng(0)
    before = np.full((60, 80, 3), 50, np.uint8)
    before[:, 40:] = 200
    for _ in range(10):
        after = pixels.glass_blur(rng, before)
        far = pixels.GLASS_PX[1] + 2 * 4  # two blurs of at most 1.2 px reach 4 px each
        np.testing.assert_array_equal(after[:, : 40 - far], 50)
        np.testing.assert_array_equal(after[:, 40 + far :], 200)
        assert after[:, 39:41].std() > 5.0  # ragged along the edge
        assert abs(after.mean() - 125.0) < 2.0


def test_motion_blur_smears_along_one_line():
    dot = np.zeros((41, 41, 3), np.uint8)
    dot[20, 20] = 255
    rng = np.random.default_rng(1)
    for _ in range(20):
        v, u = np.nonzero(pixels.motion_blur(rng, dot)[..., 0])
        spread = np.linalg.svd(np.stack([u - 20.0, v - 20.0]), compute_uv=False)
        assert spread[1] <= 1.5 * np.sqrt(len(u))  # no wider than an antialiased line
        assert np.hypot(u - 20.0, v - 20.0).max() <= 9.0  # half of 15 px, and a soft end


def test_operations_are_drawn_independently_and_in_any_order(monkeypatch):
    """Over many draws, each comes as often as asked, pairs as often as chance has it."""
    seen: list[list[str]] = []

    def watch(name):
        def operate(_, image):
            seen[-1].append(name)
            return image

        return operate

    from aerial_gnss_ros.training import variants

    asked = {"motion_blur": 0.5, "brightness": 0.3, "gaussian_blur": 0.8}
    for name in asked:
        monkeypatch.setitem(variants.PIXELS, name, watch(name))
    recipe = Recipe({**dict.fromkeys(PROBABILITIES, 0.0), **asked})
    rng = np.random.default_rng(5)
    image = np.zeros((8, 8, 3), np.uint8)
    for _ in range(4000):
        seen.append([])
        make_variant(image, np.zeros((0, 4)), recipe, rng)

    def share(*names):
        return np.mean([all(name in drawn for name in names) for drawn in seen])

    for name, probability in asked.items():
        assert share(name) == pytest.approx(probability, abs=0.03)
    assert share("motion_blur", "brightness") == pytest.approx(0.15, abs=0.03)
    both = [drawn for drawn in seen if {"motion_blur", "gaussian_blur"} <= set(drawn)]
    first = np.mean([d.index("motion_blur") < d.index("gaussian_blur") for d in both])
    assert first == pytest.approx(0.5, abs=0.05)


def test_wrong_probabilities_are_refused():
    with pytest.raises(ConfigError, match="no augmentation 'rotate'"):
        Recipe({"rotate": 0.5})
    with pytest.raises(ConfigError, match="within 0 to 1"):
        Recipe({"rotation": 1.5})
