# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""TF as the source of the camera's orientation: axes, clocks, and when trouble is reported."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.adapters.feed import Feed
from aerial_gnss_ros.adapters.tf_gimbal import TfGimbal, is_optical
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.config.telemetry import GimbalConfig
from aerial_gnss_ros.core.values.errors import ConfigError

SECOND = 10**9
TF = {"gimbal.source": "tf", "gimbal.reference": "body"}
FORWARD_OF = {"flu": [1.0, 0.0, 0.0], "optical": [0.0, 0.0, 1.0]}


def message(parent, child, rotation, stamp_ns=0):
    x, y, z, w = rotation.as_quat()
    stamp = SimpleNamespace(sec=stamp_ns // SECOND, nanosec=stamp_ns % SECOND)
    one = SimpleNamespace(
        header=SimpleNamespace(stamp=stamp, frame_id=parent),
        child_frame_id=child,
        transform=SimpleNamespace(rotation=SimpleNamespace(x=x, y=y, z=z, w=w)),
    )
    return SimpleNamespace(transforms=[one])


@pytest.mark.parametrize(
    ("frame", "axes", "kind"),
    [
        ("camera_optical_frame", "suffix", "optical"),
        ("cam0_optical", "suffix", "optical"),
        ("optical_gimbal", "suffix", "flu"),
        ("camera", "suffix", "flu"),
        ("camera", "optical", "optical"),
        ("camera_optical_frame", "flu", "flu"),
    ],
)
def test_the_frame_s_suffix_or_a_parameter_tells_which_axis_looks_forward(frame, axes, kind):
    config = GimbalConfig(camera_frame=frame, camera_axes=axes)
    assert is_optical(config) is (kind == "optical")
    turn = Rotation.from_euler("zyx", [50.0, 20.0, 10.0], degrees=True)
    (found,) = TfGimbal(config).add(message("/base_link", f"/{frame}", turn), 5, static=False)
    forward = Rotation.from_quat(found.quaternion).apply([1.0, 0.0, 0.0])
    assert forward == pytest.approx(turn.apply(FORWARD_OF[kind]))
    left = Rotation.from_quat(found.quaternion).apply([0.0, 1.0, 0.0])
    assert left == pytest.approx(turn.apply([0, 1, 0] if kind == "flu" else [-1, 0, 0]))


@pytest.mark.parametrize(("stamp", "expected"), [("header", 3 * SECOND), ("arrival", 7 * SECOND)])
def test_the_stamp_is_the_header_s_or_the_arrival(stamp, expected):
    gimbal = TfGimbal(GimbalConfig(stamp=stamp))
    sent = message("base_link", "camera_optical_frame", Rotation.identity(), 3 * SECOND)
    assert [one.stamp_ns for one in gimbal.add(sent, 7 * SECOND, static=False)] == [expected]


class _Inputs:
    def __init__(self):
        self.gimbal, self.refused = [], []

    def add_gimbal(self, one):
        self.gimbal.append(one)

    def refuse(self, name, trouble):
        self.refused.append((name, trouble))

    def add_attitude(self, _):
        pass


def test_trouble_is_reported_after_a_while_and_once_a_second():
    inputs = _Inputs()
    feed = {s.name: s for s in Feed(estimator_config(TF), inputs).subscriptions}
    assert (feed["gimbal"].topic, feed["tf_static"].topic) == ("/tf", "/tf_static")
    assert feed["tf_static"].sent_once
    for i in range(40):
        feed["gimbal"].handle(message("odom", "base_link", Rotation.identity()), i * SECOND // 10)
    assert len(inputs.refused) == 2
    name, trouble = inputs.refused[0]
    assert name == "gimbal"
    assert trouble == (
        "TF has no frame camera_optical_frame; its frames: base_link, odom (gimbal.base_frame "
        "base_link, camera_frame camera_optical_frame)"
    )
    assert not inputs.gimbal


def test_a_camera_that_tf_has_as_fixed_is_given_with_every_attitude():
    inputs = _Inputs()
    feed = {s.name: s for s in Feed(estimator_config(TF), inputs).subscriptions}
    down = Rotation.from_euler("y", 180.0, degrees=True)
    feed["tf_static"].handle(message("base_link", "camera_optical_frame", down), 0)
    stamp = SimpleNamespace(sec=4, nanosec=0)
    level = SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0)
    imu = SimpleNamespace(
        header=SimpleNamespace(stamp=stamp), orientation=level, orientation_covariance=[0.0] * 9
    )
    feed["attitude"].handle(imu, 9)
    (one,) = inputs.gimbal
    assert one.stamp_ns == 4 * SECOND
    looks = Rotation.from_quat(one.quaternion).apply([1.0, 0.0, 0.0])
    assert looks == pytest.approx([0.0, 0.0, -1.0], abs=1e-9)
    assert np.isclose(np.linalg.norm(one.quaternion), 1.0)


@pytest.mark.parametrize(
    "values", [{"gimbal.base_frame": ""}, {"gimbal.camera_frame": "base_link"}]
)
def test_two_frames_are_needed(values):
    with pytest.raises(ConfigError, match="must be two frames"):
        estimator_config(TF | values)
    assert not any(s.topic == "/tf" for s in Feed(estimator_config({}), _Inputs()).subscriptions)
