# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The bound of a flight, with and without a robot whose place is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import MapDatum
from aerial_gnss_ros.evaluation.bound import TrueFrame, bound

CAMERA = CameraModel.from_camera_info(
    1280, 720, "plumb_bob", [], [900.0, 0, 640.0, 0, 900.0, 360.0, 0, 0, 1.0]
)
LOCAL = LocalMap(MapDatum(0.23, -1.04, 0.0))
PLACES = np.array([[0.0, 18.0], [3.0, 20.0]])


def sigmas(known=None, seconds=5):
    """Return one sigma of both robots at the end of a hover, each a mean of both axes, m."""
    rotation = matrix_from_rpy(0.0, math.radians(60.0), math.radians(90.0))
    frames = [
        TrueFrame(
            CameraPose(round(t * 1e8), 0.23, -1.04, 30.0, 30.0, rotation),
            PLACES, np.array([True, True]),
        )
        for t in range(10 * seconds)
    ]  # fmt: skip
    limits = bound(estimator_config({}), CAMERA, frames, LOCAL, known)
    return np.sqrt(np.trace(limits[-1, :, :2, :2], axis1=1, axis2=2) / 2.0)


def test_the_receiver_s_offset_is_in_the_bound_and_a_known_place_takes_it_out():
    free, known = sigmas(), sigmas({0: 0.05})
    assert (free > 1.2).all()
    assert known[0] < 0.05
    assert 0.05 < known[1] < 0.3


def test_a_poorly_known_place_tells_less():
    told = [sigmas({0: sigma})[1] for sigma in (0.05, 0.5, 1.0, 100.0)]
    assert told == sorted(told)
    assert told[2] == pytest.approx(math.hypot(1.0 / math.hypot(1.0, 1.0 / 1.2), 0.1), rel=0.25)
    assert told[3] == pytest.approx(sigmas()[1], rel=0.02)
