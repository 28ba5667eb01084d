# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Outlines are of the wanted size and differ; textures have patches."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.training.shapes import shape, texture


@pytest.mark.parametrize("length", [12.0, 60.0])
def test_shapes_have_about_the_length_and_differ(length):
    rng = np.random.default_rng(3)
    made = [shape(rng, length) for _ in range(40)]
    for coverage in made:
        rows, columns = np.nonzero(coverage > 0.5)
        assert 0.0 <= coverage.min() <= coverage.max() <= 1.0
        if len(rows):
            assert max(np.ptp(rows), np.ptp(columns)) < 1.4 * length + 8
    extents = [np.ptp(np.nonzero((c > 0.5).any(axis=0))[0]) if c.max() > 0.5 else 0 for c in made]
    assert 0.35 * length < np.median(extents) < 1.2 * length
    areas = [float(coverage.sum()) / length**2 for coverage in made]
    assert max(areas) > 4 * np.quantile(areas, 0.1)


def test_textures_have_patches_of_different_colours():
    rng = np.random.default_rng(5)
    spreads = [texture(rng, (40, 30), 8.0).reshape(-1, 3).std(axis=0).max() for _ in range(30)]
    assert texture(rng, (40, 30), 8.0).shape == (30, 40, 3)
    assert np.quantile(spreads, 0.8) > 30.0
