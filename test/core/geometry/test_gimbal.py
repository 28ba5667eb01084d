# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Gimbal references, also against a recorded flight with a real two-axis gimbal."""

from __future__ import annotations

import csv
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.core.geometry import frames
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic
from aerial_gnss_ros.core.geometry.gimbal import (
    Reference,
    enu_from_camera,
    error_axes,
    mount_matrix,
)

DOWN_30 = frames.matrix_from_rpy(0.0, math.radians(30.0), 0.0)
NORTH_PITCHED = frames.matrix_from_rpy(0.0, math.radians(10.0), math.radians(90.0))
"""A body that flies north with its nose 10 deg down."""


@pytest.mark.parametrize(
    ("reference", "view"),
    [
        # direction of view in ENU for a camera that reports 30 deg down, straight ahead
        ("earth", [math.cos(math.radians(30)), 0.0, -0.5]),
        ("heading", [0.0, math.cos(math.radians(30)), -0.5]),
        ("body", [0.0, math.cos(math.radians(40)), -math.sin(math.radians(40))]),
    ],
)
def test_the_reference_decides_where_the_camera_looks(reference, view):
    matrix = enu_from_camera(reference, DOWN_30, NORTH_PITCHED, None)
    assert matrix[:, 0] == pytest.approx(view, abs=1e-12)


def test_a_fixed_camera_turns_with_the_body():
    mount = mount_matrix((0.0, 90.0, 0.0))
    matrix = enu_from_camera("fixed", None, NORTH_PITCHED, mount)
    expected = [0.0, -math.sin(math.radians(10)), -math.cos(math.radians(10))]
    assert matrix[:, 0] == pytest.approx(expected, abs=1e-12)


def test_earth_needs_no_attitude_and_the_others_say_what_they_need():
    assert enu_from_camera("earth", DOWN_30, None, None) is DOWN_30
    assert [r.value for r in Reference if r.needs_attitude] == [
        "heading",
        "body",
        "fixed",
        "mavlink_flags",
    ]
    with pytest.raises(ValueError, match="a reading must state"):
        enu_from_camera("mavlink_flags", DOWN_30, NORTH_PITCHED, None)
    with pytest.raises(ValueError, match="body's orientation"):
        enu_from_camera("heading", DOWN_30, None, None)
    with pytest.raises(ValueError, match="mount"):
        enu_from_camera("fixed", DOWN_30, NORTH_PITCHED, None)
    with pytest.raises(ValueError, match="reading"):
        enu_from_camera("earth", None, None, DOWN_30)


def test_mavlinks_heading_reference_is_the_same_rotation():
    # reference: R_enu_gimbal = N Rz(psi) R(q) D, psi clockwise from north
    psi = math.radians(235.3)
    gimbal_ned = Rotation.from_euler("ZYX", [20.0, -35.0, 3.0], degrees=True).as_matrix()
    turn = Rotation.from_euler("Z", psi).as_matrix()
    expected = frames.ENU_FROM_NED @ turn @ gimbal_ned @ frames.FLU_FROM_FRD
    level_flu = frames.FLU_FROM_FRD @ gimbal_ned @ frames.FLU_FROM_FRD
    body = frames.matrix_from_rpy(0.1, -0.2, frames.yaw_from_heading(psi))
    assert enu_from_camera("heading", level_flu, body, None) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("pitch_deg", [0.0, 30.0, 89.9999, 90.0, 95.0])
def test_error_axes_are_level_and_follow_the_top_of_the_view(pitch_deg):
    yaw = 0.7
    matrix = frames.matrix_from_rpy(0.0, math.radians(pitch_deg), yaw)
    roll, pitch, heading = error_axes(matrix).T
    assert roll == pytest.approx([math.cos(yaw), math.sin(yaw), 0.0], abs=1e-9)
    assert pitch == pytest.approx([-math.sin(yaw), math.cos(yaw), 0.0], abs=1e-9)
    assert heading == pytest.approx([0.0, 0.0, 1.0])


def test_a_camera_on_its_side_still_has_level_error_axes():
    axes = error_axes(frames.matrix_from_rpy(math.pi / 2, 0.0, 0.0))
    assert axes == pytest.approx(np.eye(3), abs=1e-9)


def test_body_reference_finds_the_recorded_frame_centre(shared_data):
    """A real aircraft and gimbal: platform and sensor angles give the direction to the centre."""
    errors = []
    with (shared_data / "klv_cheyenne.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            value = {name: float(text) for name, text in row.items() if text}
            body = _enu_flu(
                value, "platform_heading_deg", "platform_pitch_deg", "platform_roll_deg"
            )
            sensor = _ned_frd(
                value, "sensor_rel_azimuth_deg", "sensor_rel_elevation_deg", "sensor_rel_roll_deg"
            )
            gimbal = frames.FLU_FROM_FRD @ sensor @ frames.FLU_FROM_FRD
            view = enu_from_camera("body", gimbal, body, None)[:, 0]
            to_centre = enu_from_geodetic(
                math.radians(value["frame_center_lat_deg"]),
                math.radians(value["frame_center_lon_deg"]),
                value["frame_center_elev_msl_m"],
                math.radians(value["sensor_lat_deg"]),
                math.radians(value["sensor_lon_deg"]),
                value["sensor_alt_msl_m"],
            )
            cosine = view @ to_centre / np.linalg.norm(to_centre)
            errors.append(math.degrees(math.acos(min(1.0, cosine))))
    assert len(errors) == 407
    assert np.median(errors) == pytest.approx(0.104, abs=0.003)
    assert np.percentile(errors, 95) == pytest.approx(0.379, abs=0.01)


def _ned_frd(value, *names):
    yaw, pitch, roll = (value[name] for name in names)
    return Rotation.from_euler("ZYX", [yaw, pitch, roll], degrees=True).as_matrix()


def _enu_flu(value, *names):
    return frames.ENU_FROM_NED @ _ned_frd(value, *names) @ frames.FLU_FROM_FRD
