# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The paper's own field trial: the camera's axis meets the water at the robot."""

from __future__ import annotations

import csv
import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, yaw_from_heading
from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse
from aerial_gnss_ros.core.georeferencing.localization import locate
from aerial_gnss_ros.core.values.camera_pose import CameraPose

ROBOT = math.radians(13.1939387032944), math.radians(-59.6415065636197)


def _pose(row):
    pitch = -math.radians(float(row["GIMBAL.pitch"]))  # down is negative there, earth-referenced
    yaw = yaw_from_heading(math.radians(float(row["OSD.yaw [360]"])))
    return CameraPose(
        0,
        math.radians(float(row["OSD.latitude"])),
        math.radians(float(row["OSD.longitude"])),
        float(row["OSD.height [ft]"]) * 0.3048,
        math.nan,
        matrix_from_rpy(0.0, pitch, yaw),
    )


def test_the_camera_axis_meets_the_water_at_the_robot(shared_data):
    camera = CameraModel.from_focal_length(0.0203, 0.036, None, 1920, 1080)
    with (shared_data / "dji_single_robot.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 663
    errors, sigmas = [], []
    for row in rows:
        got = locate(_pose(row), camera, [[960, 540]], Noise())
        assert got.reasons == (None,)
        distance, _, _ = geodesic_inverse(*ROBOT, got.latitude[0], got.longitude[0])
        errors.append(distance)
        sigmas.append(math.sqrt(np.trace(got.covariance[0])))
    assert np.median(errors) == pytest.approx(0.52, abs=0.02)
    assert np.median(errors) < 0.6
    # truth and estimate share one receiver, so the stated error must be larger than what is seen
    assert np.mean(np.array(errors) < 3.0 * np.array(sigmas)) > 0.95
