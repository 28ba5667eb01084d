# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A picture that stands still while the camera moves, and telemetry that stops dead."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.faults.frozen_input import FrozenInputDetector
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame

CAMERA = CameraModel.from_camera_info(
    1280, 720, "plumb_bob", [], [900.0, 0, 640.0, 0, 900.0, 360.0, 0, 0, 1.0]
)
DOWN = matrix_from_rpy(0.0, np.pi / 2, 0.0)


def pose(east=0.0, north=0.0):
    return MapPose(np.array([east, north, 30.0]), DOWN)


def frame(i, u=500.0, score=0.8):
    return DetectionFrame(
        i * 100_000_000, "camera", np.array([[u, 300.0]]), np.array([[40.0, 20.0]]),
        np.array([score]), ("aqua",),
    )  # fmt: skip


def pictures(frames, poses):
    still = FrozenInputDetector(2.0)
    return [still.image_frozen(one, CAMERA, at) for one, at in zip(frames, poses, strict=True)]


def test_a_picture_that_repeats_itself_while_the_drone_flies_is_refused_after_a_moment():
    """2 m/s at 30 m by 900 px: 6 px an image; more than 0.3 s are four images."""
    moving = [pose(0.2 * i) for i in range(9)]
    assert pictures([frame(i) for i in range(9)], moving) == [False] * 4 + [True] * 5
    changed = [frame(i, u=500.0 + (i >= 6)) for i in range(9)]
    assert pictures(changed, moving)[4:] == [True, True, False, False, False]
    scores = [frame(i, score=0.8 + 0.001 * i) for i in range(9)]
    assert not any(pictures(scores, moving))


def test_a_picture_may_stand_still_with_its_camera():
    """3 px are 0.1 m here."""
    assert not any(pictures([frame(i) for i in range(20)], [pose()] * 20))
    swaying = [pose(0.09 * (i % 2)) for i in range(20)]
    assert not any(pictures([frame(i) for i in range(20)], swaying))
    farther = [pose(0.11 * (i % 2)) for i in range(20)]
    assert any(pictures([frame(i) for i in range(20)], farther))


def test_images_without_boxes_tell_nothing():
    empty = frame(0).keep(np.array([False]))
    assert pictures([empty] * 9, [pose(0.5 * i) for i in range(9)]) == [False] * 9


def reported(easts, rate=10):
    still = FrozenInputDetector(2.0)
    return [still.telemetry_frozen(i * 10**9 // rate, pose(east)) for i, east in enumerate(easts)]


@pytest.mark.parametrize(("speed", "noise", "stands"), [(2.0, 0.03, True), (2.0, 0.0, False),
                                                        (0.5, 0.003, False)])  # fmt: skip
def test_telemetry_that_stops_dead_in_flight(speed, noise, stands):
    """A simulator without noise may stop so, a drone does not; slow motion is hardly detectable."""
    rng = np.random.default_rng(1)
    flown = [0.1 * speed * i + noise * rng.standard_normal() for i in range(20)]
    found = reported([*flown, *flown[-1:] * 15, *(flown[-1] + 0.2 * i for i in (1, 2, 3))])
    assert found == [False] * 30 + [stands] * 5 + [False] * 3


def test_a_jump_is_no_motion():
    rng = np.random.default_rng(1)
    hover = [0.03 * rng.standard_normal() for _ in range(20)]
    assert not any(reported([*hover, *[50.0] * 30]))
