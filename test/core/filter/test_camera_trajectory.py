# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Poses one after the other: jumps of the receiver are no motion, nor are new times of a scene."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.camera_trajectory import CameraTrajectory
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.values.events import Events

SECOND_NS = 1_000_000_000
SPEED = np.array([2.0, 0.0, 0.0])


def frame(t, position, late_s=0.0, jumped=()):
    """Return an image at a time, s, whose pose is that of some time before."""
    stamp_ns = round(t * SECOND_NS)
    pose = SimpleNamespace(
        stamp_ns=stamp_ns - round(late_s * SECOND_NS),
        interpolation_noise=lambda _passed: np.zeros(6),
    )
    return SimpleNamespace(
        detections=SimpleNamespace(stamp_ns=stamp_ns), camera=None, pose=pose, jumped=jumped,
        in_map=MapPose(np.asarray(position, float), np.eye(3)),
    )  # fmt: skip


def fly(trajectory, times, moved=0.0, late_s=0.0):
    """Fly East at 2 m/s, displaced to the North; return what each image's position is found to be.

    An image of `late_s` shows the camera as it was before.
    """
    found = []
    for t in times:
        jumped = (0.0, moved) if moved else ()
        image = frame(t, SPEED * (t - late_s) + (0.0, moved, 30.0), late_s, jumped)
        found.append(trajectory.follow_position(image, 1.0))
        trajectory.look(image, 0.0)
    return found


def test_the_view_has_the_rates_and_the_foretold_place_of_a_steady_flight():
    trajectory = CameraTrajectory(0.0, Events())
    assert trajectory.view is None
    found = fly(trajectory, np.arange(0.0, 3.0, 0.1))
    assert found == [None] * 30
    assert trajectory.passed == pytest.approx(0.1)
    view = trajectory.seen_from
    np.testing.assert_allclose(view.rates, [*SPEED, 0.0, 0.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(view.foretold, SPEED * 2.9 + (0.0, 0.0, 30.0), atol=1e-6)


def test_a_jump_of_the_receiver_is_taken_out_until_it_is_accepted():
    trajectory = CameraTrajectory(0.0, Events())
    fly(trajectory, np.arange(0.0, 2.0, 0.1))
    fly(trajectory, np.arange(2.0, 3.8, 0.1), moved=40.0)
    assert trajectory.seen_from.measured.position[1] == pytest.approx(0.0, abs=1e-9)
    found = fly(trajectory, np.arange(3.8, 4.3, 0.1), moved=40.0)
    (jump,) = (jump for jump in found if jump is not None)
    np.testing.assert_allclose(jump, [0.0, 40.0, 0.0], atol=1e-6)
    assert trajectory.seen_from.measured.position[1] == pytest.approx(40.0)
    np.testing.assert_allclose(trajectory.motion.velocity, SPEED, atol=1e-6)


def test_another_latency_is_no_motion_of_the_camera():
    trajectory = CameraTrajectory(0.0, Events())
    fly(trajectory, np.arange(0.0, 2.0, 0.1))
    fly(trajectory, [2.0], late_s=0.5)
    assert trajectory.seen_from.applied == pytest.approx(0.5)
    np.testing.assert_allclose(trajectory.motion.velocity, SPEED, atol=1e-6)


@pytest.mark.parametrize(("searched", "passed"), [(False, 0.1 + 0.5), (True, 0.1)])
def test_a_larger_latency_is_contained_in_poses_from_then_on(searched, passed):
    trajectory = CameraTrajectory(0.0, Events())
    fly(trajectory, np.arange(0.0, 2.0, 0.1))
    trajectory.delay(0.5, searched)
    trajectory.note_recalibration()
    image = frame(2.0, SPEED * 2.0 + (9.0, 9.0, 30.0))
    assert trajectory.follow_position(image, 1.0) is None  # another calibration: no jump
    trajectory.look(image, 0.0)
    assert trajectory.passed == pytest.approx(passed)
    assert trajectory.seen_from.applied == pytest.approx(-0.5)
    np.testing.assert_allclose(trajectory.motion.velocity, SPEED, atol=1e-6)
