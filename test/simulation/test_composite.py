# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Layers over one another, and rectangles of pixels."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.simulation.composite import (
    Body,
    contrasts,
    merged,
    paint_above,
    paint_below,
    slices,
)
from aerial_gnss_ros.simulation.view import Window

AREA = Window(10, 20, 4, 3)


def layer(window, above=0.0, cover=0.0, below=0.0, hidden=0.0):
    shape = (window.height, window.width)
    over = np.full((*shape, 4), above, np.float32)
    over[..., 3] = cover
    return SimpleNamespace(
        window=window, above=over, below=np.full((*shape, 3), below, np.float32),
        hidden=np.full((*shape, 3), hidden, np.float32),
    )  # fmt: skip


def planes(value=1.0):
    return [np.full((AREA.height, AREA.width), value, np.float32) for _ in range(3)]


@pytest.mark.parametrize(
    ("window", "changed"),
    [(Window(11, 21, 2, 1), 2), (Window(13, 22, 9, 9), 1), (Window(0, 0, 5, 5), 0)],
)
def test_what_is_over_water_covers_what_is_behind_it(window, changed):
    """Half covered, with a light of 0.3 of its own: 1 becomes 0.5 + 0.3."""
    light = planes()
    paint_above(light, layer(window, above=0.3, cover=0.5), AREA)
    for plane in light:
        assert np.count_nonzero(plane != 1.0) == changed
        assert plane[plane != 1.0] == pytest.approx([0.8] * changed)


def test_what_is_under_water_hides_its_glow_and_adds_its_own():
    glow = planes(2.0)
    paint_below(glow, layer(Window(12, 20, 1, 3), below=0.1, hidden=0.25), AREA)
    assert glow[0][:, 2] == pytest.approx([1.6] * 3)
    assert glow[0][:, [0, 1, 3]] == pytest.approx(2.0)


def test_contrast_is_the_mean_change_over_what_is_visible_of_a_robot():
    window = Window(10, 20, 2, 3)
    visible = np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 0.0]], np.float32)
    clean = np.zeros((3, 4, 3), np.uint8)
    dirty = clean.copy()
    dirty[0, 0], dirty[1, 0] = 51, (0, 0, 51)
    robot = SimpleNamespace(robot_id="aqua_1")
    bodies = [
        Body(None, robot, layer(window), visible, 1.0),
        Body(None, None, layer(window), visible, 1.0),  # a prop
        Body(None, SimpleNamespace(robot_id="far"), layer(Window(0, 0, 2, 3)), visible, 1.0),
        Body(None, SimpleNamespace(robot_id="hidden"), layer(window), 0.0 * visible, 1.0),
    ]
    found = contrasts(bodies, AREA, clean, dirty)
    assert found == {"aqua_1": pytest.approx(0.5 * (0.2 + 0.2 / 3.0)), "hidden": 0.0}


windows = st.builds(
    Window, st.integers(0, 30), st.integers(0, 30), st.integers(1, 12), st.integers(1, 12)
)


@given(st.lists(windows, max_size=8))
def test_merged_windows_are_apart_and_cover_all(given_windows):
    found = merged(given_windows)
    for i, one in enumerate(found):
        assert all(one.clipped(other) is None for other in found[:i])
    covered = np.zeros((50, 50), bool)
    for one in found:
        covered[slices(one, Window(0, 0, 50, 50))] = True
    for one in given_windows:
        assert covered[slices(one, Window(0, 0, 50, 50))].all()
        assert any(other.clipped(one) == one for other in found)
