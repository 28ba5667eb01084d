# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Windows of an image, and rays through its pixels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.view import GRID, ViewPose, Window, optical_rays, project_points

PINHOLE = CameraModel(
    200, 120, "plumb_bob", np.array([[150.0, 0, 99.5], [0, 160.0, 59.5], [0, 0, 1.0]]), np.zeros(5)
)
DOWN = ViewPose(np.array([5.0, -3.0, 10.0]), matrix_from_rpy(0.0, 0.5 * np.pi, 0.0))
windows = st.builds(
    Window, st.integers(-9, 30), st.integers(-9, 30), st.integers(1, 20), st.integers(1, 20)
)


def pixels(window):
    return {
        (x, y)
        for x in range(window.x, window.x + window.width)
        for y in range(window.y, window.y + window.height)
    }


@given(windows, windows)
def test_windows_share_and_unite_their_pixels(one, other):
    part = one.clipped(other)
    assert (pixels(part) if part else set()) == pixels(one) & pixels(other)
    both = one.united(other)
    assert pixels(one) | pixels(other) <= pixels(both)
    for smaller in (Window(both.x + 1, both.y, both.width - 1, both.height),
                    Window(both.x, both.y, both.width, both.height - 1)):  # fmt: skip
        assert not pixels(one) | pixels(other) <= pixels(smaller)


@pytest.mark.parametrize("window", [Window(0, 0, 200, 120), Window(40, 30, 57, 41)])
def test_a_pinholes_rays_are_straight_to_its_pixels(window):
    rays = optical_rays(PINHOLE, window)
    assert rays.shape == (window.height, window.width, 3)
    v, u = np.mgrid[: window.height, : window.width]
    assert rays[..., 0] / rays[..., 2] == pytest.approx((u + window.x - 99.5) / 150.0, abs=5e-4)
    assert rays[..., 1] / rays[..., 2] == pytest.approx((v + window.y - 59.5) / 160.0, abs=5e-4)
    assert np.linalg.norm(rays, axis=-1) == pytest.approx(1.0, abs=1e-6)


def test_a_sliver_is_refused():
    with pytest.raises(ConfigError, match=str(2 * GRID + 1)):
        optical_rays(PINHOLE, Window(190, 0, 5, 100))


def test_points_are_seen_below_a_camera_that_looks_down():
    """Ahead is east, up in the image: 2 m of 10 m east are 32 px up, 2 m north are 30 px left."""
    found, front = project_points(
        PINHOLE, DOWN, np.array([[5.0, -3.0, 0.0], [7.0, -1.0, 0.0], [5.0, -3.0, 20.0]])
    )
    assert front.tolist() == [True, True, False]
    assert found[0] == pytest.approx([99.5, 59.5])
    assert found[1] == pytest.approx([69.5, 27.5])


def test_what_is_under_water_is_seen_nearer_to_the_middle():
    surface, deep = project_points(PINHOLE, DOWN, np.array([[9.0, -3.0, 0.0], [9.0, -3.0, -2.0]]))[
        0
    ]
    straight = 59.5 - 160.0 * 4.0 / 12.0
    assert surface[1] < deep[1] < straight
