# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images wait in the order of their stamps, each for a limited time."""

from __future__ import annotations

from collections import Counter

from aerial_gnss_ros.core.estimation.image_queue import MAX_WAITING, ImageQueue
from aerial_gnss_ros.core.values.detection_frame import empty_detections


def _queue(*stamps):
    queue = ImageQueue(Counter())
    for stamp_ns in stamps:
        queue.add(empty_detections(stamp_ns), {})
    return queue


def _taken(queue):
    stamps = []
    while queue.waiting:
        stamps.append(queue.waiting[0].frame.stamp_ns)
        queue.pop()
    return stamps


def test_images_are_taken_in_the_order_of_their_stamps():
    assert _taken(_queue(30, 10, 20)) == [10, 20, 30]


def test_a_stamp_is_taken_once_and_none_before_the_last_one():
    queue = _queue(10, 20, 20)
    queue.pop()
    for stamp_ns in (10, 9, 11):
        queue.add(empty_detections(stamp_ns), {})
    assert _taken(queue) == [11, 20]
    assert queue._dropped == {"duplicate": 2, "out_of_order": 1}


def test_an_image_is_late_when_it_has_waited_as_long_as_it_may():
    queue = _queue(5)
    assert not queue.is_late(100, 10)
    queue.tick(100)
    assert [queue.is_late(now, 10) for now in (109, 110)] == [False, True]
    queue.tick(50)  # the clock was set back
    assert [queue.is_late(now, 10) for now in (59, 60)] == [False, True]


def test_a_prediction_lies_between_the_last_image_and_the_next():
    queue = _queue(10, 20)
    assert queue.time_before(15) is None
    queue.pop()
    assert [queue.time_before(stamp_ns) for stamp_ns in (10, 15, 25)] == [None, 15, 19]
    queue.pop()
    assert queue.time_before(25) == 25


def test_it_says_when_too_many_wait():
    queue = _queue(*range(MAX_WAITING))
    assert len(queue.waiting) == MAX_WAITING
    assert queue.add(empty_detections(MAX_WAITING), {})
