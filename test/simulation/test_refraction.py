# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The crossing of the water surface obeys Snell's law."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.simulation.refraction import WATER_INDEX, apparent_points


def test_hand_checked_case() -> None:
    """30 deg in water leaves at asin(1.34 / 2) = 42.067 deg: 1 m down shifts by tan 30 = 0.5774 m.

    From 10 m up the crossing is at 10 tan 42.067 deg = 9.0262 m.
    """
    crossing = 10.0 * np.tan(np.arcsin(1.34 * 0.5))
    point = np.array([[crossing + np.tan(np.pi / 6), 0.0, -1.0]])
    seen = apparent_points((0.0, 0.0, 10.0), point)
    assert crossing == pytest.approx(9.0262, abs=1e-3)
    np.testing.assert_allclose(seen, [[crossing, 0.0, 0.0]], atol=1e-9)


def test_straight_down_and_dry_points_stay() -> None:
    """Below the camera nothing shifts, and above the surface nothing is refracted."""
    points = np.array([[3.0, 4.0, -2.0], [7.0, -1.0, 0.0], [7.0, -1.0, 0.4]])
    seen = apparent_points((3.0, 4.0, 8.0), points)
    np.testing.assert_allclose(seen[0], [3.0, 4.0, 0.0], atol=1e-12)
    np.testing.assert_array_equal(seen[1:], points[1:])


@given(
    st.floats(1.0, 100.0),
    st.floats(0.001, 20.0),
    st.floats(0.0, 400.0),
    st.floats(-np.pi, np.pi),
)
def test_snell(height: float, depth: float, reach: float, yaw: float) -> None:
    """Sines of the angles on both sides stand in the ratio of the indices, in one plane."""
    camera = np.array([5.0, -7.0, height])
    direction = np.array([np.cos(yaw), np.sin(yaw)])
    point = np.array([*(camera[:2] + reach * direction), -depth])
    seen = apparent_points(camera, point[None])[0]
    in_air, in_water = seen - camera, point - seen
    sine_air = np.hypot(*in_air[:2]) / np.linalg.norm(in_air)
    sine_water = np.hypot(*in_water[:2]) / np.linalg.norm(in_water)
    assert sine_air == pytest.approx(WATER_INDEX * sine_water, abs=1e-7)
    assert abs(in_air[0] * direction[1] - in_air[1] * direction[0]) < 1e-6
