# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Operations do what their names say; light of a temperature has the right colour."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.training.variants import PROBABILITIES, Recipe, make_variant


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
