# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""PX4's versioned topics."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.adapters.versions import newest_version


@pytest.mark.parametrize(
    ("present", "expected"),
    [
        ([], "/a/home"),
        (["/a/home"], "/a/home"),
        (["/a/home", "/a/home_v1"], "/a/home"),
        (["/a/home_v2", "/a/home_v10", "/a/home_v1"], "/a/home_v10"),
        (["/b/a/home_v1", "/a/home_v", "/a/home_v1x", "/a/home_vx"], "/a/home"),
    ],
)
def test_the_plain_name_first_then_the_newest(present, expected):
    assert newest_version("/a/home", present) == expected
