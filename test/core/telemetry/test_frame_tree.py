# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Orientations composed of transforms: against scipy, and what is missing in the tree."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from aerial_gnss_ros.core.telemetry.frame_tree import MAX_FRAMES, FrameTree
from aerial_gnss_ros.core.values.samples import Orientation

SECOND = 10**9
BACK = Rotation.from_euler("zyx", [100.0, 20.0, -30.0], degrees=True)
LENS = Rotation.from_euler("zyx", [-90.0, 0.0, -90.0], degrees=True)


def _yaw(t):
    return Rotation.from_euler("z", 40.0 * t, degrees=True)


def _tilt(t):
    return Rotation.from_euler("y", 25.0 * t - 10.0, degrees=True)


def _turn(t, rotation):
    return Orientation(round(t * SECOND), rotation.as_quat())


class _Tf:
    """A base beside a body that carries a gimbal of two joints with a camera."""

    def __init__(self):
        self.tree, self.now = FrameTree("base", "lens", 1.0), 0.0

    def put(self, parent, child, t, rotation, static=False):
        self.now = max(self.now, t)
        self.tree.add(parent, child, _turn(t, rotation), static, round(self.now * SECOND))

    def fixed(self):
        self.put("body", "base", 0.0, BACK, static=True)
        self.put("tilt", "lens", 0.0, LENS, static=True)

    @property
    def trouble(self):
        return self.tree.trouble(round(self.now * SECOND))


def test_moving_and_static_transforms_are_composed_at_the_stamps_of_all_that_move():
    tf = _Tf()
    tf.fixed()
    found = []
    for i in range(12):  # one joint is reported at 10 Hz, the other at 4 Hz, a little later
        if i % 3 == 0:
            tf.put("body", "yaw", 0.1 * i + 0.05, _yaw(0.1 * i + 0.05))
            found += tf.tree.ready()
        tf.put("yaw", "tilt", 0.1 * i, _tilt(0.1 * i))
        found += tf.tree.ready()
    stamps = [one.stamp_ns / SECOND for one in found]
    assert stamps == pytest.approx(
        [0.05, 0.1, 0.2, 0.3, 0.35, 0.4, 0.5, 0.6, 0.65, 0.7, 0.8, 0.9, 0.95]
    )
    yaw_at = Slerp(
        [0.05, 0.35, 0.65, 0.95], Rotation.concatenate([*map(_yaw, (0.05, 0.35, 0.65, 0.95))])
    )
    for t, one in zip(stamps, found, strict=True):
        expected = BACK.inv() * yaw_at(t) * _tilt(t) * LENS
        apart = expected.inv() * Rotation.from_quat(one.quaternion)
        assert apart.magnitude() < 1e-6
    assert tf.trouble == ""


def test_a_camera_fixed_to_the_base_has_one_orientation_at_any_time():
    tf = _Tf()
    tf.fixed()
    assert tf.tree.static(5) is None
    tf.put("body", "tilt", 0.0, _tilt(1.0), static=True)
    expected = (BACK.inv() * _tilt(1.0) * LENS).as_quat()
    one = tf.tree.static(5)
    assert one.stamp_ns == 5
    assert np.abs(one.quaternion @ expected) == pytest.approx(1.0)
    assert tf.tree.ready() == []
    tf.put("body", "tilt", 1.0, _tilt(2.0))
    assert tf.tree.static(5) is None
    assert len(tf.tree.ready()) == 1


def test_what_is_missing_is_said():
    tf = _Tf()
    assert tf.trouble == "TF has no frame base; its frames: none yet"
    tf.fixed()
    assert tf.trouble == "TF does not connect them: base hangs on body, lens hangs on tilt"
    tf.put("map", "body", 0.0, BACK)
    tf.put("tilt", "yaw", 0.0, _yaw(0.0))
    tf.put("yaw", "tilt", 0.0, _yaw(0.0))
    assert tf.trouble == "TF has a loop: tilt -> yaw -> tilt"
    tf.put("body", "yaw", 0.0, _yaw(0.0))
    assert tf.trouble == ""
    tf.put("map", "body", 2.0, BACK)
    tf.put("body", "yaw", 2.0, _yaw(2.0))
    assert tf.trouble == "the transform yaw -> tilt stopped 2.0 s ago"
    tf.put("yaw", "tilt", 2.0, _tilt(2.0))
    assert tf.trouble == ""


def test_a_frame_of_itself_is_a_loop():
    tf = _Tf()
    tf.put("lens", "lens", 0.0, LENS)
    assert tf.trouble == "TF has a loop: lens -> lens"


def test_samples_far_apart_are_not_interpolated():
    tf = _Tf()
    tf.fixed()
    for at_yaw, at_tilt in ((0.0, 0.0), (1.5, 0.75), (2.0, 2.0)):
        tf.put("body", "yaw", at_yaw, _yaw(at_yaw))
        tf.put("yaw", "tilt", at_tilt, _tilt(at_tilt))
    assert [one.stamp_ns for one in tf.tree.ready()] == [0, 2 * SECOND]


def test_time_that_is_set_back_begins_anew():
    tf = _Tf()
    tf.fixed()
    for start in (100.0, 0.0):
        for t in (start, start + 0.1):
            tf.put("body", "yaw", t, _yaw(t))
            tf.put("yaw", "tilt", t, _tilt(t))
        assert [one.stamp_ns / SECOND for one in tf.tree.ready()] == [start, start + 0.1]


def test_foreign_frames_take_no_more_than_bounded_memory():
    tf = _Tf()
    for i in range(MAX_FRAMES + 100):
        tf.put("map", f"robot_{i}", 0.0, BACK)
    assert len(tf.tree._parents) == MAX_FRAMES
    assert len(tf.trouble) < 200
