# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The overview's JSON: units, null for what is unknown, and a light for each input."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.adapters.overview import Light, input_lights, overview_text
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.telemetry.input_status import InputState, InputStatus
from aerial_gnss_ros.core.values.overview import Overview
from aerial_gnss_ros.core.values.reference_place import ReferencePlace

sys.path.insert(0, str(Path(__file__).parent))

from one_robot import RESULT, ROBOT, STAMP

BUOY = ReferencePlace("buoy", "buoy", math.radians(13.1), math.radians(-59.1), np.diag([4.0, 1.0]))
AREA = ((np.array([[-59.0, 13.0], [-58.0, 13.0], [-58.0, 14.0]]),),)


def shown(result=RESULT, pixel=(100.0, 50.0), depth=1.5, **other):
    seen = Overview(
        result,
        np.radians([[13.0, -59.0], [13.1, -59.0], [13.1, -58.9]]),
        np.array([pixel] * len(result.estimates)).reshape(-1, 2),
        np.full(len(result.estimates), depth),
        (BUOY,),
        (1280, 720),
    )
    return json.loads(overview_text(seen, STAMP + 7, AREA, **other))


def test_positions_are_latitude_before_longitude_in_degrees():
    fields = shown()
    assert fields["robots"][0]["place"] == [13.0, -59.0]
    assert fields["footprint"][1] == [13.1, -59.0]
    assert fields["references"] == [{"name": "buoy", "place": [13.1, -59.1], "sigma_m": 2.0}]
    assert fields["area"] == [[[[13.0, -59.0], [13.0, -58.0], [14.0, -58.0]]]]
    assert (fields["stamp_ns"], fields["now_ns"]) == (STAMP, STAMP + 7)


def test_a_robot_is_stated_with_covariance_depth_and_pixel():
    (robot,) = shown()["robots"]
    assert (robot["id"], robot["state"]) == ("aqua_1", "confirmed")
    assert robot["covariance_m2"] == [4.0, 0.5, 9.0]
    assert robot["velocity_mps"] == [0.0, 2.0]
    assert (robot["depth_m"], robot["pixel"]) == (1.5, [100.0, 50.0])


def test_what_is_unknown_is_null():
    robot = replace(ROBOT, velocity=np.full(2, np.nan))
    fields = shown(replace(RESULT, estimates=(robot,), pose=None), (math.nan, math.nan))
    assert fields["drone"] is None
    assert fields["robots"][0]["pixel"] is None
    assert fields["robots"][0]["velocity_mps"] == [None, None]


@pytest.mark.parametrize(("yaw", "heading"), [(0.0, 90.0), (90.0, 0.0), (180.0, 270.0)])
def test_the_camera_looks_along_its_optical_axis(yaw, heading):
    matrix = matrix_from_rpy(0.0, math.radians(60.0), math.radians(yaw))
    drone = shown(replace(RESULT, pose=replace(RESULT.pose, enu_from_camera=matrix)))["drone"]
    assert drone["camera_heading_deg"] == pytest.approx(heading)
    assert drone["camera_below_horizon_deg"] == 60.0
    assert drone["height_m"] == 22.0


def test_a_camera_that_looks_straight_down_has_no_heading():
    matrix = matrix_from_rpy(0.0, math.pi / 2, 0.3)
    drone = shown(replace(RESULT, pose=replace(RESULT.pose, enu_from_camera=matrix)))["drone"]
    assert drone["camera_heading_deg"] is None


@pytest.mark.parametrize(
    ("state", "level"),
    [
        (InputState.OK, "ok"),
        (InputState.STALE, "warning"),
        (InputState.WAITING, "error"),
        (InputState.BAD, "error"),
    ],
)
def test_an_input_has_a_light(state, level):
    status = InputStatus("fix", state, 9, 3, trouble="its latitude is NaN")
    light, positions = input_lights({"fix": status})
    assert (light.name, light.level) == ("fix", level)
    assert positions == Light("positions", "ok", "consistent")
    if state is InputState.BAD:
        assert light.words == "the last message was unusable (3 of 9): its latitude is NaN"


def test_what_is_not_used_has_no_light_and_complaints_do():
    unused = InputStatus("attitude", InputState.UNUSED)
    (light,) = input_lights({"attitude": unused}, ["", "2 of 3 boxes are refused."])
    assert light == Light("positions", "warning", "2 of 3 boxes are refused.")
