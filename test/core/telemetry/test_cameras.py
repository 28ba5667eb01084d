# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The newest camera not later than an image holds, with the calibrated focal length."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.telemetry.cameras import Cameras
from aerial_gnss_ros.core.values.rejection import Reason

ONE, OTHER = (
    CameraModel(640, 480, "plumb_bob", np.array([[f, 0, 320], [0, f, 240], [0, 0, 1.0]]))
    for f in (500.0, 600.0)
)


def test_a_camera_holds_until_it_is_replaced():
    cameras = Cameras(estimator_config({}))
    assert cameras.at(10) is Reason.NO_CAMERA_INFO
    cameras.add(10, ONE)
    cameras.add(20, None)
    cameras.add(30, OTHER)
    assert cameras.at(9) is Reason.NO_CAMERA_INFO
    assert cameras.at(10) is cameras.at(19) is ONE
    assert cameras.at(20) is Reason.BAD_CAMERA_INFO
    assert cameras.at(30) is OTHER


def test_the_newest_camera_outlives_time_that_begins_anew():
    cameras = Cameras(estimator_config({}))
    cameras.clear()
    assert cameras.at(0) is Reason.NO_CAMERA_INFO
    cameras.add(10, ONE)
    cameras.add(20, OTHER)
    cameras.clear()
    assert cameras.at(0) is OTHER


def test_the_focal_length_is_scaled_once_for_each_camera():
    cameras = Cameras(estimator_config({"calibration.focal_scale": 1.1}))
    cameras.add(0, ONE)
    found = cameras.at(5)
    assert found.K[0, 0] == pytest.approx(550.0)
    assert cameras.at(6) is found
    cameras.add(10, OTHER)
    assert cameras.at(10).K[0, 0] == pytest.approx(660.0)


def test_a_camera_of_the_parameters_needs_no_message():
    given = {
        "camera.source": "parameters", "camera.focal_length_mm": 4.0,
        "camera.sensor_width_mm": 6.0, "camera.image_width_px": 600, "camera.image_height_px": 400,
    }  # fmt: skip
    cameras = Cameras(estimator_config(given))
    cameras.add(0, ONE)
    assert cameras.at(5) is cameras.fixed
    assert cameras.fixed.K[0, 0] == pytest.approx(400.0)
