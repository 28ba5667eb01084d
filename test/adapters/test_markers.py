# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots as a viewer draws them: ellipses that hold 95 of 100 positions, and names."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.adapters.map_frame import Frames
from aerial_gnss_ros.adapters.markers import LEAST_DIAMETER_M, ellipse_axes, marker_array
from aerial_gnss_ros.core.values.estimates import FrameResult, State

sys.path.insert(0, str(Path(__file__).parent))

from one_robot import DATUM, ROBOT

ROUND = replace(ROBOT, covariance=np.diag([1.0, 4.0, 1.0, 1.0]))


def drawn(*robots):
    """Return the markers of an image."""
    result = FrameResult(5, "camera", robots, (), DATUM)
    return marker_array(result, Frames("drone1/map", "drone1/"))["markers"]


@pytest.mark.parametrize(
    ("yaw_deg", "long", "short"), [(0.0, 2.0, 1.0), (30.0, 3.0, 0.5), (-60.0, 1.0, 0.0)]
)
def test_axes_of_an_ellipse_are_those_it_was_made_of(yaw_deg, long, short):
    c, s = math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg))
    turn = np.array([[c, -s], [s, c]])
    found = ellipse_axes(turn @ np.diag([long**2, short**2]) @ turn.T)
    assert found[:2] == pytest.approx((long, short), abs=1e-7)
    assert math.sin(found[2] - math.radians(yaw_deg)) == pytest.approx(0.0, abs=1e-9)


def test_markers_replace_the_whole_picture():
    clear, ellipse, name = drawn(ROUND)
    assert clear["action"] == 3  # DELETEALL: a lost robot disappears
    assert [(m["ns"], m["id"], m["action"]) for m in (ellipse, name)] == [
        ("aqua_1", 0, 0), ("aqua_1", 1, 0),
    ]  # fmt: skip
    assert {m["header"]["frame_id"] for m in (clear, ellipse, name)} == {"drone1/map"}
    # 95 %: 2.4477 sigma to each side; the long axis points north.
    assert ellipse["scale"]["x"] == pytest.approx(2 * 2.4477 * 2.0, rel=1e-4)
    assert ellipse["scale"]["y"] == pytest.approx(2 * 2.4477 * 1.0, rel=1e-4)
    turn = ellipse["pose"]["orientation"]
    assert abs(2.0 * math.atan2(turn["z"], turn["w"])) == pytest.approx(math.pi / 2)
    assert ellipse["pose"]["position"] == {"x": 30.0, "y": 20.0, "z": 0.0}
    assert name["pose"]["position"]["z"] > 0.0
    assert name["text"] == "aqua_1"


def test_a_robot_that_is_not_seen_is_drawn_as_such_and_a_sure_one_can_be_seen():
    _, ellipse, name = drawn(replace(ROBOT, state=State.COASTING, covariance=np.zeros((4, 4))))
    assert name["text"] == "aqua_1 (not seen)"
    assert ellipse["color"]["r"] > ellipse["color"]["g"]
    assert ellipse["scale"]["x"] == ellipse["scale"]["y"] == LEAST_DIAMETER_M
