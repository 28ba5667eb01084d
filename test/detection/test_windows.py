# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Windows cover images and boxes, and are as small and few as they can be."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.detection.windows import Window, around, grid, split


@given(
    st.tuples(st.integers(1, 2000), st.integers(1, 2000)),
    st.tuples(st.integers(32, 1400), st.integers(32, 1400)),
    st.integers(0, 30),
)
def test_a_grid_covers_the_image_with_its_overlap(size, tile, overlap):
    windows = grid(size, tile, overlap)
    for axis in (0, 1):
        starts = sorted({(w.left, w.top)[axis] for w in windows})
        side = min(tile[axis], size[axis])
        assert starts[0] == 0
        assert starts[-1] + side == size[axis]
        assert (np.diff(starts) <= max(1, side - overlap)).all()
        assert all((w.width, w.height)[axis] == side for w in windows)


@given(
    st.tuples(st.integers(64, 4000), st.integers(64, 4000)), st.integers(1, 40), st.integers(0, 64)
)
def test_a_split_has_no_more_parts_than_asked_and_covers_all(size, most, overlap):
    windows = split(size, most, overlap)
    assert 1 <= len(windows) <= most
    assert {w.left for w in windows} >= {0}
    assert max(w.left + w.width for w in windows) == size[0]
    assert max(w.top + w.height for w in windows) == size[1]


def test_the_parts_of_a_common_image():
    windows = split((1280, 720), 15, 64)
    assert len(windows) == 15
    assert windows[0] == Window(0, 0, 320, 288)


@given(
    st.lists(
        st.tuples(st.floats(-50, 1300), st.floats(-50, 740), st.floats(1, 900), st.floats(1, 500)),
        min_size=1,
        max_size=8,
    )
)
def test_windows_round_boxes_cover_what_of_them_lies_in_the_image(given_boxes):
    low = np.array([[left, top] for left, top, _, _ in given_boxes])
    corners = np.hstack([low, low + [[w, h] for _, _, w, h in given_boxes]])
    size = np.array([1280, 720])
    windows = around(corners, (1280, 720))
    for window in windows:
        assert window.left >= 0 <= window.top
        assert (window.corners[2:] <= size).all()
    inside = np.clip(corners, -0.5, np.tile(size, 2) - 0.5)
    for box in inside[(inside[:, 2:] > inside[:, :2]).all(axis=1)]:
        assert any(
            (w.corners[:2] <= box[:2]).all() and (w.corners[2:] >= box[2:]).all() for w in windows
        )


def test_boxes_close_together_share_a_window_and_others_do_not():
    near = np.array([[100.0, 100.0, 160.0, 160.0], [170.0, 100.0, 230.0, 160.0]])
    assert len(around(near, (1280, 720))) == 1
    apart = near + np.array([[0.0] * 4, [600.0, 0.0, 600.0, 0.0]])
    assert len(around(apart, (1280, 720))) == 2
