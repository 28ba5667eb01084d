# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lines of YOLO's label files, read and written."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.training.label_lines import OVERHANG, as_text, parse

shares = st.floats(0.01, 0.99)


@given(st.integers(0, 3), shares, shares, st.floats(0.01, 1.0), st.floats(0.01, 1.0))
def test_what_is_written_is_read_back(number, x, y, width, height):
    width, height = min(width, 2 * x, 2 - 2 * x), min(height, 2 * y, 2 - 2 * y)
    box = np.array([x * 1280, y * 720, width * 1280, height * 720])
    (line,) = as_text([number], [box], 1280, 720).splitlines()
    found = parse(line, 4)
    assert found[0] == number
    assert found[1:] == pytest.approx((x, y, width, height), abs=1e-6)


@pytest.mark.parametrize(("beyond", "valid"), [(0.9 * OVERHANG, True), (1.1 * OVERHANG, False)])
def test_an_edge_may_reach_beyond_the_image_by_rounding(beyond, valid):
    for line in (f"0 {0.1 - beyond} 0.5 0.2 0.2", f"0 0.5 {0.9 + beyond} 0.2 0.2"):
        if valid:
            assert parse(line, 1)[0] == 0
        else:
            with pytest.raises(InputError, match="reaches beyond the image, from"):
                parse(line, 1)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("0 0.5 0.5 0.2", "has 4 values, but a box is"),
        ("0 0.5 half 0.2 0.2", "is not five numbers"),
        ("0 0.5 inf 0.2 0.2", "is not five numbers"),
        ("2 0.5 0.5 0.2 0.2", "class 2 is not in data.yaml, which has 0 to 1"),
        ("0.5 0.5 0.5 0.2 0.2", "class 0.5 is not in data.yaml"),
        ("0 32 32 9 9", "is outside 0 to 1: it may be in pixels"),
        ("0 0.5 0.5 0 0.2", "is not above 0"),
        ("0 0.5 0.5 0.2 1.01", "is not above 0 and at most 1"),
    ],
)
def test_what_is_no_box_is_named(line, words):
    with pytest.raises(InputError, match=words):
        parse(line, 2)
