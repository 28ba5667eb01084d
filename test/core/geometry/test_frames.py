# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Frames, rotations and signs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from aerial_gnss_ros.core.geometry import frames

angles = st.floats(-math.pi, math.pi)
quaternions = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)


@pytest.mark.parametrize(
    ("heading_deg", "yaw_deg"), [(0, 90), (90, 0), (180, -90), (270, -180), (235.3, -145.3)]
)
def test_heading_is_clockwise_from_north_and_yaw_counter_clockwise_from_east(heading_deg, yaw_deg):
    yaw = frames.yaw_from_heading(math.radians(heading_deg))
    assert math.degrees(yaw) == pytest.approx(yaw_deg, abs=1e-9)
    assert math.degrees(frames.heading_from_yaw(yaw)) == pytest.approx(heading_deg, abs=1e-9)


@pytest.mark.parametrize(
    ("matrix", "axis", "becomes"),
    [
        (frames.ENU_FROM_NED, [1, 0, 0], [0, 1, 0]),  # north
        (frames.ENU_FROM_NED, [0, 0, 1], [0, 0, -1]),  # down
        (frames.ENU_FROM_NWU, [1, 0, 0], [0, 1, 0]),  # north
        (frames.ENU_FROM_NWU, [0, 1, 0], [-1, 0, 0]),  # west
        (frames.FLU_FROM_FRD, [0, 1, 0], [0, -1, 0]),  # right
        (frames.FLU_FROM_OPTICAL, [0, 0, 1], [1, 0, 0]),  # depth is forward
        (frames.FLU_FROM_OPTICAL, [1, 0, 0], [0, -1, 0]),  # right
        (frames.FLU_FROM_OPTICAL, [0, 1, 0], [0, 0, -1]),  # down
    ],
)
def test_constant_matrices_turn_the_axes_they_name(matrix, axis, becomes):
    assert (matrix @ axis).tolist() == becomes


def test_a_camera_with_pitch_90_looks_down_and_its_image_top_points_along_the_heading():
    matrix = frames.matrix_from_rpy(0.0, math.pi / 2, frames.yaw_from_heading(0.0))
    optical = matrix @ frames.FLU_FROM_OPTICAL
    assert optical @ [0, 0, 1] == pytest.approx([0, 0, -1], abs=1e-15)
    assert optical @ [0, -1, 0] == pytest.approx([0, 1, 0], abs=1e-15)  # top of the image: north
    assert optical @ [1, 0, 0] == pytest.approx([1, 0, 0], abs=1e-15)  # right of it: east


def test_aerospace_angles_convert_as_the_drivers_documents_say():
    # DJI: heading 60, pitch -30 (down), roll 5 in NED/FRD; psdk_ros2 gives them as ENU FLU.
    ned = Rotation.from_euler("ZYX", [60, -30, 5], degrees=True).as_matrix()
    through_ned = frames.ENU_FROM_NED @ ned @ frames.FLU_FROM_FRD
    direct = frames.matrix_from_rpy(*np.radians([5, 30, 30]))
    assert through_ned == pytest.approx(direct, abs=1e-12)


@given(quaternions)
def test_quaternions_agree_with_scipy_and_come_back(q):
    matrix = frames.matrix_from_quaternion(q)
    assert matrix == pytest.approx(Rotation.from_quat(q).as_matrix(), abs=1e-12)
    back = frames.quaternion_from_matrix(matrix)
    assert back[3] >= 0.0
    assert abs(np.dot(back, q)) / np.linalg.norm(q) == pytest.approx(1.0, abs=1e-12)


def test_half_turns_survive_the_matrix():
    for q in np.eye(4):
        matrix = frames.matrix_from_quaternion(q)
        assert np.abs(frames.quaternion_from_matrix(matrix)) == pytest.approx(q)


def test_a_zero_quaternion_is_not_a_number():
    assert np.isnan(frames.matrix_from_quaternion(np.zeros(4))).any()


@given(angles, st.floats(-1.57, 1.57), angles)
def test_roll_pitch_yaw_agree_with_scipy_and_come_back(roll, pitch, yaw):
    matrix = frames.matrix_from_rpy(roll, pitch, yaw)
    expected = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
    assert matrix == pytest.approx(expected, abs=1e-12)
    again = frames.matrix_from_rpy(*frames.rpy_from_matrix(matrix))
    assert again == pytest.approx(matrix, abs=1e-9)


def test_straight_down_has_yaw_and_no_roll():
    matrix = frames.matrix_from_rpy(0.3, math.pi / 2, 0.8)
    roll, pitch, yaw = frames.rpy_from_matrix(matrix)
    assert (roll, pitch, yaw) == pytest.approx((0.0, math.pi / 2, 0.5), abs=1e-6)


def test_functions_work_on_leading_axes():
    rng = np.random.default_rng(1)
    q = rng.normal(size=(4, 5, 4))
    matrices = frames.matrix_from_quaternion(q)
    assert matrices.shape == (4, 5, 3, 3)
    assert frames.quaternion_from_matrix(matrices).shape == (4, 5, 4)
    rpy = frames.rpy_from_matrix(matrices)
    assert frames.matrix_from_rpy(rpy[..., 0], rpy[..., 1], rpy[..., 2]) == pytest.approx(matrices)
    a, b = rng.normal(size=(2, 7, 3))
    assert np.einsum("nij,nj->ni", frames.skew(a), b) == pytest.approx(np.cross(a, b))


@given(quaternions, quaternions, st.floats(0.0, 1.0))
def test_slerp_agrees_with_scipy_whatever_the_signs(q0, q1, t):
    pair = Rotation.from_quat([q0, q1])
    unit0, unit1 = pair.as_quat()
    expected = Slerp([0.0, 1.0], pair)(t).as_matrix()
    angle = (pair[0].inv() * pair[1]).magnitude()
    if angle > math.pi - 1e-4:
        return  # both ways are equally short
    got = frames.matrix_from_quaternion(frames.slerp(unit0, -unit1, t))
    assert got == pytest.approx(expected, abs=1e-6)


def test_slerp_gives_the_ends_and_the_middle():
    q0, q1 = np.array([0, 0, 0, 1.0]), np.array([0, 0, 1.0, 0])  # half a turn about up
    assert frames.slerp(q0, q1, 0.0) == pytest.approx(q0)
    assert frames.slerp(q0, q1, 1.0) == pytest.approx(q1, abs=1e-15)
    quarter = [0, 0, math.sin(math.pi / 4), math.cos(math.pi / 4)]
    assert frames.slerp(q0, q1, 0.5) == pytest.approx(quarter)


def test_yaw_of_a_pitched_body_is_where_its_nose_points():
    matrix = frames.matrix_from_rpy(0.2, -0.4, 1.1)
    assert frames.yaw_of(matrix) == pytest.approx(1.1)


@given(st.floats(-100.0, 100.0))
def test_wrapped_angles_are_the_same_direction(angle):
    wrapped = frames.wrap_angle(angle)
    assert -math.pi <= wrapped < math.pi
    assert math.cos(wrapped - angle) == pytest.approx(1.0)


def _quaternion(angles):
    return frames.quaternion_from_matrix(frames.matrix_from_rpy(*angles))


@pytest.mark.parametrize(
    ("world", "outer"),
    [("enu", np.eye(3)), ("ned", frames.ENU_FROM_NED), ("nwu", frames.ENU_FROM_NWU)],
)
@pytest.mark.parametrize(("body", "inner"), [("flu", np.eye(3)), ("frd", frames.FLU_FROM_FRD)])
def test_other_axes_become_enu_and_flu_as_matrices_do(world, outer, body, inner):
    q = _quaternion((0.3, -0.7, 2.5))
    turned = frames.to_enu_flu(q, world, body)
    expected = outer @ frames.matrix_from_quaternion(q) @ inner
    assert frames.matrix_from_quaternion(turned) == pytest.approx(expected, abs=1e-12)
    level = frames.to_level_flu(q, body)
    expected = inner @ frames.matrix_from_quaternion(q) @ inner
    assert frames.matrix_from_quaternion(level) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("length", [0.0, 0.5, 3.0])
def test_changing_axes_keeps_what_is_no_rotation(length):
    q = length * _quaternion((0.3, -0.7, 2.5))
    for turned in (frames.to_enu_flu(q, "ned", "frd"), frames.to_level_flu(q, "frd")):
        assert np.linalg.norm(turned) == pytest.approx(length)


def test_quaternion_products_are_those_of_matrices():
    a, b = _quaternion((0.3, -0.7, 2.5)), _quaternion((-1.0, 0.2, 0.4))
    product = frames.matrix_from_quaternion(frames.quaternion_product(a, b))
    expected = frames.matrix_from_quaternion(a) @ frames.matrix_from_quaternion(b)
    assert product == pytest.approx(expected, abs=1e-12)
