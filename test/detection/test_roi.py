# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Following the robots: each found in every image, at a fraction of the pixels."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from aerial_gnss_ros.detection.config import detector_config
from aerial_gnss_ros.detection.roi import FollowingDetector

_BLOBS = runpy.run_path(str(Path(__file__).with_name("blobs.py")))
BlobDetector, boxes, sea = (_BLOBS[name] for name in ("BlobDetector", "boxes", "sea"))

SIZE, SCAN = (1280, 720), 15
WHOLE = SIZE


class Flight:
    """Images of robots that move, and what a following detector makes of them."""

    def __init__(self, **search):
        self.inner = BlobDetector()
        values = {"mode": "roi", "scan_images": SCAN} | search
        self.detector = FollowingDetector(self.inner, detector_config({"search": values}))

    def see(self, *robots, size=SIZE):
        """Return the boxes found; `self.inner.shown` are the sizes of the parts looked at."""
        self.inner.shown = []
        return boxes(self.detector.detect(sea(size, *robots)))


def moving(start, step, size=(30, 20)):
    return lambda i: (start[0] + round(i * step[0]), start[1] + round(i * step[1]), *size)


def test_robots_are_found_in_every_image_once_and_cheaply():
    flight = Flight()
    paths = [moving((100, 100), (7, 2)), moving((160, 110), (7, 1)), moving((900, 600), (-9, -3))]
    for i in range(80):
        robots = [path(i) for path in paths]
        assert flight.see(*robots) == sorted(robots), i
        pixels = sum(width * height for width, height in flight.inner.shown)
        assert (flight.inner.shown == [WHOLE]) == (i == 0)
        assert i == 0 or pixels < 0.3 * WHOLE[0] * WHOLE[1]


@pytest.mark.parametrize("place", [(5, 5), (640, 300), (1240, 690), (305, 270)])
def test_a_robot_that_appears_is_found_within_a_scan_and_reported_whole(place):
    flight = Flight()
    old, new = (700, 500, 30, 20), (*place, 30, 20)
    for _ in range(20):
        flight.see(old)
    seen = [flight.see(old, new) for _ in range(SCAN + 1)]
    assert all(found in ([old], sorted([old, new])) for found in seen)  # never a part of it
    first = seen.index(sorted([old, new]))
    assert seen[first:] == [sorted([old, new])] * (SCAN + 1 - first)


def test_a_robot_larger_than_the_overlap_is_reported_only_whole():
    flight = Flight(overlap=32)
    old, new = (60, 600, 30, 20), (500, 150, 260, 180)  # over an edge of every part near it
    for _ in range(5):
        flight.see(old)
    seen = [flight.see(old, new) for _ in range(SCAN + 3)]
    assert all(found in ([old], sorted([old, new])) for found in seen)
    assert seen[-1] == sorted([old, new])


def test_with_nothing_followed_the_whole_image_is_looked_at():
    flight = Flight()
    for _ in range(3):
        assert flight.see() == []
        assert flight.inner.shown == [WHOLE]
    assert flight.see((640, 360, 20, 20)) == [(640, 360, 20, 20)]


def test_a_sure_robot_that_jumps_is_found_again_by_a_faster_scan():
    flight = Flight()
    other = (900, 600, 30, 20)
    for _ in range(SCAN + 1):
        flight.see((100, 100, 30, 20), other)
    jumped = (400, 300, 30, 20)
    seen = [flight.see(jumped, other) for _ in range(3 + SCAN // 2)]
    assert seen[-1] == sorted([jumped, other])
    assert WHOLE not in flight.inner.shown


def test_when_all_jump_the_whole_image_is_looked_at():
    flight = Flight()
    for _ in range(SCAN + 1):
        flight.see((100, 100, 30, 20), (900, 600, 30, 20))
    jumped = [(400, 300, 30, 20), (1200, 300, 30, 20)]
    seen = [flight.see(*jumped) for _ in range(3)]
    assert seen[-1] == jumped
    assert flight.inner.shown == [WHOLE]


def test_a_robot_that_dives_costs_one_fast_scan_and_is_found_where_it_surfaces():
    flight = Flight()
    stays = (900, 600, 30, 20)
    for _ in range(SCAN + 1):
        flight.see((100, 100, 30, 20), stays)
    parts, most = 0, 0.0
    for _ in range(3 * SCAN):
        assert flight.see(stays) == [stays]
        parts += len(flight.inner.shown)
        most = max(most, sum(width * height for width, height in flight.inner.shown))
    # A window for the one that stays, for ten images one where the other was, and the scan: once
    # two parts an image until it has been over all.
    assert parts == 3 * SCAN + 10 + 3 * SCAN + SCAN // 2
    assert most < 0.4 * WHOLE[0] * WHOLE[1]  # no image takes long
    seen = [flight.see((130, 120, 30, 20), stays) for _ in range(SCAN + 1)]
    assert len(seen[-1]) == 2


def test_one_blink_of_the_network_loses_nothing():
    flight = Flight()
    path = moving((100, 100), (12, 0))
    for i in range(10):
        flight.see(path(i))
    flight.inner.blind = True
    assert flight.see(path(10)) == []
    flight.inner.blind = False
    assert flight.see(path(11)) == [path(11)]
    assert WHOLE not in flight.inner.shown


def test_a_robot_that_leaves_the_image_is_forgotten():
    flight = Flight()
    path = moving((1180, 300), (20, 0))
    for i in range(8):
        flight.see(path(i))
    flight.see()
    assert flight.see() == []
    assert flight.inner.shown == [WHOLE]


def test_many_robots_are_looked_for_in_the_whole_image():
    flight = Flight()
    robots = [(60 + 240 * i, 60 + 200 * j, 30, 20) for i in range(5) for j in range(3)]
    for _ in range(2):
        assert flight.see(*robots) == sorted(robots)
    assert flight.inner.shown == [WHOLE]


def test_images_of_another_size_begin_anew():
    flight = Flight()
    for _ in range(3):
        flight.see((100, 100, 30, 20))
    assert flight.see((500, 300, 30, 20), size=(640, 360)) == [(500, 300, 30, 20)]
    assert flight.inner.shown == [(640, 360)]


def test_equal_images_give_equal_boxes():
    path = moving((100, 100), (11, 5))
    first, second = Flight(), Flight()
    assert [first.see(path(i)) for i in range(30)] == [second.see(path(i)) for i in range(30)]


def test_the_stages_add_up_over_the_parts():
    flight = Flight()
    flight.see((100, 100, 30, 20))
    found = flight.detector.detect(sea(SIZE, (100, 100, 30, 20)))
    assert found.timings_ms["infer"] == 4.0  # a window and a part
    assert set(found.timings_ms) == {"pre", "infer", "post"}
