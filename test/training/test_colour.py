# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Light of a temperature has the right colour."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.training.colour import chromaticity, gains, table


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
