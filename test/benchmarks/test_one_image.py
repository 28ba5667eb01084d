# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Calls, files, changes and returns are counted as the words say."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import one_image
from one_image import Way, calls

from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy


def test_changes_and_returns():
    assert Way.of([]) == Way(0, 0, 0, 0)
    assert Way.of(["a"]) == Way(1, 1, 0, 0)
    assert Way.of(["a", "a", "b", "b"]) == Way(4, 2, 1, 0)
    assert Way.of(["a", "b", "a", "a", "c", "b"]) == Way(6, 3, 4, 2)


def test_only_calls_inside_the_package_count():
    found = calls(lambda: matrix_from_rpy(0.1, 0.2, 0.3))
    assert found[0] == ("core/geometry/frames.py", "matrix_from_rpy")
    assert {file.split("/")[0] for file, _ in found} == {"core"}
    assert sys.getprofile() is None


def test_an_image_takes_the_same_way_each_time():
    first, second = (one_image.way(3, 12) for _ in range(2))
    assert first == second
    assert ("core/tracker/tracker.py", "update") in first
