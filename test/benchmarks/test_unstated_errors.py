# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Inputs become as wrong as the table says, and what is constant is contained."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import unstated_errors

from aerial_gnss_ros.core.geometry.frames import (
    matrix_from_quaternion,
    matrix_from_rpy,
    quaternion_from_matrix,
)


def changed(case, message, t=0.0):
    """Return a message after the change of a case, on whatever topic."""
    unstated_errors.CASES[case][1](message, t)
    return message


def test_a_height_is_too_large_and_ever_more_so():
    assert changed("height -2 m", SimpleNamespace(data=30.0), 9.0).data == 28.0
    assert changed("height 0.1 m/s", SimpleNamespace(data=30.0), 20.0).data == pytest.approx(32.0)


@pytest.mark.parametrize(
    ("case", "azimuth_deg", "turned_deg"),
    [
        ("roll 2 deg", 30.0, (2.0, 0.0, 0.0)),
        ("pitch -2 deg", 30.0, (0.0, -2.0, 0.0)),
        ("heading 5 deg", 30.0, (0.0, 0.0, 5.0)),  # counterclockwise
        ("deviation 3 deg", 90.0, (0.0, 0.0, 3.0)),
        ("deviation 3 deg", 0.0, (0.0, 0.0, 0.0)),
        ("deviation 3 deg", -30.0, (0.0, 0.0, -1.5)),
    ],
)
def test_a_camera_is_turned_about_level_axes(case, azimuth_deg, turned_deg):
    yaw, down = math.radians(90.0 - azimuth_deg), math.radians(40.0)
    level, camera = matrix_from_rpy(0.0, 0.0, yaw), matrix_from_rpy(0.0, down, yaw)
    q = SimpleNamespace(**dict(zip("xyzw", quaternion_from_matrix(camera), strict=True)))
    changed(case, SimpleNamespace(quaternion=q))
    found = matrix_from_quaternion((q.x, q.y, q.z, q.w)) @ camera.T
    expected = level @ matrix_from_rpy(*np.radians(turned_deg)) @ level.T
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_lens_and_boxes():
    lens = SimpleNamespace(k=np.arange(9.0), p=np.arange(12.0))
    changed("focal length +10 %", lens)
    assert lens.k.tolist() == pytest.approx([0.0, 1.0, 2.0, 3.0, 4.4, 5.0, 6.0, 7.0, 8.0])
    assert lens.p[5] == pytest.approx(5.5)
    place = SimpleNamespace(x=100.0, y=25.0)
    box = SimpleNamespace(bbox=SimpleNamespace(center=SimpleNamespace(position=place)))
    changed("boxes on 16 px", SimpleNamespace(detections=[box]))
    assert (place.x, place.y) == (96.0, 32.0)


@pytest.mark.flights
@pytest.mark.parametrize(
    ("case", "flight"),
    [
        ("height 2 m", "orbit40_moving_quiet"),
        ("heading 5 deg", "orbit40_moving_quiet"),
        ("deviation 5 deg", "orbit30_still"),
    ],
)
def test_a_constant_error_is_contained(case, flight, shared_data):
    folder = shared_data / "independent_flights"
    if not folder.is_dir():
        pytest.skip(f"no independent flights: {folder} is absent")
    found = unstated_errors.fly(case, folder / flight)
    assert found.positions > 0.95
    assert found.wrong < 0.01
    assert found.names == 3
