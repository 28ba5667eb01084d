# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which boxes are used, and what is odd of all of them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.georeferencing.detection_filter import (
    MAX_USUAL_BOXES,
    MAX_USUAL_FACTOR,
    MEMORY_IMAGES,
    UNKNOWN_BOXES,
    BoxCountMonitor,
    UnknownClassMonitor,
    refusals,
    rejections,
)
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.rejection import Reason


def _frame(*boxes):
    centers, sizes, scores, names = zip(*boxes, strict=True)
    arrays = (np.array(one, np.float64) for one in (centers, sizes, scores))
    return DetectionFrame(7, "camera", *arrays, names)


GOOD = ((10.0, 20.0), (4.0, 6.0), 0.5, "aqua")


@pytest.mark.parametrize(
    ("box", "reason"),
    [
        (GOOD, None),
        (((10.0, 20.0), (0.0, 0.0), 0.5, "aqua"), None),
        (((10.0, 20.0), (4.0, 6.0), 0.49, "aqua"), Reason.LOW_SCORE),
        (((10.0, 20.0), (4.0, 6.0), 0.5, "boat"), Reason.WRONG_CLASS),
        (((10.0, 20.0), (4.0, 6.0), 0.49, "boat"), Reason.LOW_SCORE),
        (((10.0, 20.0), (4.0, -1.0), 0.5, "aqua"), Reason.BAD_DETECTIONS),
        (((10.0, 20.0), (-1.0, 6.0), 0.5, "aqua"), Reason.BAD_DETECTIONS),
        (((math.nan, 20.0), (4.0, 6.0), 0.5, "aqua"), Reason.BAD_DETECTIONS),
        (((10.0, 20.0), (4.0, math.inf), 0.5, "aqua"), Reason.BAD_DETECTIONS),
        (((10.0, 20.0), (4.0, 6.0), math.nan, "boat"), Reason.BAD_DETECTIONS),
    ],
)
def test_a_box_is_used_or_refused_for_one_reason(box, reason):
    frame = _frame(GOOD, box)
    found = refusals(frame, 0.5, ("aqua", "buoy"))
    assert found == [None, reason]
    reported = rejections(frame, found)
    assert [(one.stamp_ns, one.reason) for one in reported] == ([(7, reason)] if reason else [])


def test_without_classes_all_are_robots():
    assert refusals(_frame(GOOD, ((1.0, 2.0), (3.0, 4.0), 0.9, "boat")), 0.5, ()) == [None, None]


def test_rejections_say_where_their_boxes_were():
    boat = ((1.0, 2.0), (3.0, 4.0), 0.9, "boat")
    frame = _frame(boat, GOOD, boat)
    reported = rejections(frame, refusals(frame, 0.5, ("aqua",)))
    assert [(one.u_px, one.v_px) for one in reported] == [(1.0, 2.0)] * 2


def test_far_more_boxes_than_usual_are_noticed():
    monitor = BoxCountMonitor()
    assert [monitor.update(10) for _ in range(5)] == [None] * 5
    most = MAX_USUAL_BOXES + MAX_USUAL_FACTOR * 10
    assert monitor.update(round(most)) is None
    usual = 10 + (most - 10) / MEMORY_IMAGES
    assert monitor.update(200) == pytest.approx(usual)
    crowd = BoxCountMonitor()  # where many were there from the beginning
    assert [crowd.update(200) for _ in range(5)] == [None] * 5


def test_only_unknown_classes_are_noticed_once_they_are_no_chance():
    monitor = UnknownClassMonitor()
    wrong = [Reason.WRONG_CLASS]
    assert monitor.update((), []) == ()
    for _ in range(UNKNOWN_BOXES - 1):
        assert monitor.update(("boat",), wrong) == ()
    assert monitor.update(("kite", "x"), [*wrong, Reason.LOW_SCORE]) == ("boat", "kite")
    assert monitor.update(("aqua",), [None]) == ()
    assert monitor.update(("boat",), wrong) == ()  # a robot was seen: not all names are wrong
    mixed = UnknownClassMonitor()
    assert mixed.update(("boat",) * UNKNOWN_BOXES + ("aqua",), [*wrong * UNKNOWN_BOXES, None]) == ()
