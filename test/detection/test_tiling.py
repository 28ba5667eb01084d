# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tiles: every robot once and whole, wherever the tiles' edges cut it."""

from __future__ import annotations

import runpy
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.detection.config import detector_config
from aerial_gnss_ros.detection.tiling import TilingDetector

_BLOBS = runpy.run_path(str(Path(__file__).with_name("blobs.py")))
BlobDetector, boxes, sea = (_BLOBS[name] for name in ("BlobDetector", "boxes", "sea"))

SIZE = (640, 360)


def tiling(**values):
    search = {"mode": "tiles", "tile": 256, "overlap": 64} | values
    return TilingDetector(BlobDetector(), detector_config({"search": search}))


@given(
    st.integers(0, SIZE[0] - 1), st.integers(0, SIZE[1] - 1), st.integers(6, 150),
    st.integers(6, 100),
)  # fmt: skip
def test_one_robot_is_found_once_and_whole_wherever_it_is(left, top, width, height):
    right, bottom = min(SIZE[0], left + width), min(SIZE[1], top + height)
    box = (left, top, right - left, bottom - top)
    assert boxes(tiling().detect(sea(SIZE, box))) == [box]


def test_several_robots_in_the_overlaps_stay_several():
    # tiles of 256 at 0, 192, 384 across and 0, 104 down
    robots = [(200, 110, 20, 20), (230, 110, 20, 20), (390, 200, 40, 12), (0, 0, 10, 10)]
    found = tiling().detect(sea(SIZE, *robots))
    assert boxes(found) == sorted(robots)
    assert found.timings_ms["infer"] == 2.0 * 6


def test_an_image_smaller_than_a_tile_is_shown_once():
    tiles = tiling(tile=1280)
    assert boxes(tiles.detect(sea((300, 200), (5, 5, 9, 9)))) == [(5, 5, 9, 9)]
    assert tiles._inner.shown == [(300, 200)]


def test_tiles_are_no_larger_than_what_the_network_takes_unshrunk():
    config = detector_config({"image_size": 320, "search": {"mode": "tiles"}})
    tiles = TilingDetector(BlobDetector(), config)
    tiles.detect(sea((1280, 720)))
    assert max(tiles._inner.shown) == (320, 320)
