# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The released code's behaviour, at the test geometry whose errors are known."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path

import numpy as np

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.georeferencing import localization
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import MapDatum

_PATH = Path(__file__).resolve().parents[2] / "benchmarks" / "released_code.py"
_SPEC = importlib.util.spec_from_file_location("released_code", _PATH)
assert _SPEC is not None and _SPEC.loader is not None  # noqa: PT018
released_code = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(released_code)


def test_its_errors_at_a_known_geometry() -> None:
    """6.7 m high, 59.1 deg off nadir, pixel (1400, 300): C1 alone is 9.6 m, with C2 it is more."""
    yaw = math.radians(90.0 - 235.3)
    camera = CameraModel(
        1920, 1080, "plumb_bob", np.array([[1082.7, 0, 960], [0, 1082.7, 540], [0, 0, 1]]),
        np.zeros(5),
    )  # fmt: skip
    pose = CameraPose(
        0, 0.23, -1.04, 6.7, math.nan, matrix_from_rpy(0.0, math.radians(90 - 59.1), yaw)
    )
    center, size = np.array([[1400.0, 300.0]]), np.array([[80.0, 60.0]])
    around = LocalMap(MapDatum(0.23, -1.04, 0.0))
    exact = localization.locate(pose, camera, center, Noise())
    true = around.positions(exact.latitude, exact.longitude)[0]
    assert abs(np.linalg.norm(true) - 21.8) < 0.1
    level = matrix_from_rpy(0.0, 0.0, yaw)
    found = around.positions(*released_code.locate(pose, camera, center, size, level))[0]
    assert 9.0 < np.linalg.norm(found - true) < 12.0


def test_looking_past_straight_down_is_folded_forward() -> None:
    """C3: 3 deg backward is taken for 3 deg forward, 0.73 m at 7 m."""
    camera = CameraModel(
        1920, 1080, "plumb_bob", np.array([[1082.7, 0, 960], [0, 1082.7, 540], [0, 0, 1]]),
        np.zeros(5),
    )  # fmt: skip
    pose = CameraPose(0, 0.23, -1.04, 7.0, math.nan, matrix_from_rpy(0.0, 0.5 * math.pi, 0.0))
    around = LocalMap(MapDatum(0.23, -1.04, 0.0))
    # right edge at the middle column, upper edge at 0: C2 then puts the box 26.5 deg up
    box = np.array([[960.0 - 40.0, 30.0]]), np.array([[80.0, 60.0]])
    north = []
    for pitch in (-3.0, 3.0):
        body = matrix_from_rpy(0.0, math.radians(pitch), 0.5 * math.pi)
        north.append(around.positions(*released_code.locate(pose, camera, *box, body))[0, 1])
    assert abs(north[0] - north[1]) < 1e-6
    assert abs(north[0] - 7.0 * math.tan(math.radians(3.0))) < 0.1
