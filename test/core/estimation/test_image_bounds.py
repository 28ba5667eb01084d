# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A camera of smaller images than those with the boxes is reported; single false boxes are not."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.estimation.image_bounds import ImageBounds
from aerial_gnss_ros.core.values.events import Events

HALF = CameraModel.from_camera_info(
    640, 360, "plumb_bob", [], [450.0, 0, 320.0, 0, 450.0, 180.0, 0, 0, 1.0]
)
INSIDE, BESIDE, BELOW = [640.0, 360.0], [641.0, 100.0], [100.0, 361.0]


def reported(sea, seconds, centers):
    """Return what is said where each second has an image with such boxes."""
    log = Events()
    bounds = ImageBounds("camera_info", log)
    for t in range(seconds):
        bounds.update(sea.boxes(t, centers), HALF)
    return log.drain()


def test_a_camera_of_half_the_size_is_reported_once_after_10_s(sea):
    assert reported(sea, 10, [INSIDE, BESIDE, BELOW]) == []
    (words,) = reported(sea, 60, [INSIDE, BESIDE, BELOW])
    assert words.startswith("20 of 30 boxes lie outside the 640 x 360 px of camera_info, ")


@pytest.mark.parametrize("centers", [[INSIDE, BESIDE], [INSIDE, INSIDE, BELOW], [BESIDE], []])
def test_half_of_the_boxes_or_fewer_than_20_are_not(sea, centers):
    assert reported(sea, 60, centers) == []


def test_an_estimator_reports_it_even_without_a_pose(sea):
    engine = sea.estimator()
    engine.add_camera(sea.stamp(0.0), HALF)
    for i in range(60):
        engine.add_detections(sea.boxes(0.25 * i, [[900.0, 600.0]]))
        engine.advance(sea.stamp(10.0 * i))  # no telemetry arrives
    (words,) = [one for one in engine.take_events() if "camera_info" in one]
    assert words.startswith("40 of 40 boxes lie outside the 640 x 360 px")
