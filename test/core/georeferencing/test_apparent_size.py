# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lengths of boxes against hand-checkable ones: straight down, slanting, cut off, uncertain."""

from __future__ import annotations

import csv
import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.georeferencing.apparent_size import SizeCheck, wrong_size
from aerial_gnss_ros.core.georeferencing.localization import locate
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame

CAMERA = CameraModel.from_camera_info(
    2000, 1000, "plumb_bob", [], [1000.0, 0, 1000.0, 0, 1000.0, 500.0, 0, 0, 1.0]
)
UNASKED = MapPose(np.zeros(3), np.eye(3))
QUIET = {"noise": {"box_center_px": 0.1, "height_m": 0.01, "gimbal_pitch_deg": 0.01}}
# e^(3 * 0.2): foam, pose and the detector's margin.
TOLERANCE = math.exp(0.6)


def wrong(size, length_m, *, down_deg=90.0, height=20.0, center=(1000.0, 500.0), more=None):
    config = estimator_config({"classes": {"aqua": {"length_m": length_m}}, **(more or QUIET)})
    matrix = matrix_from_rpy(0.0, math.radians(down_deg), 0.0)
    pose = CameraPose(0, 0.9, 0.1, height, math.nan, matrix)
    boxes = DetectionFrame(
        0, "camera", np.array([center]), np.array([size], float), np.ones(1), ("aqua",)
    )
    frame = PosedFrame(boxes, CAMERA, pose, UNASKED)
    points = locate(pose, CAMERA, boxes.centers, config.noise, config)
    check = SizeCheck(config)
    assert check.used
    return bool(wrong_size(check.fit(frame, points), points.valid)[0])


@pytest.mark.parametrize(
    ("size", "length_m", "refused"),
    [
        # 20 m above, 1000 px: 50 px are 1 m.
        ((50, 20), [0.9, 1.1], False),
        ((20, 50), [0.9, 1.1], False),
        ((50 * 1.1 * TOLERANCE * 0.97, 10), [0.9, 1.1], False),
        ((50 * 1.1 * TOLERANCE * 1.03, 10), [0.9, 1.1], True),
        ((10, 50 * 1.1 * TOLERANCE * 1.03), [0.9, 1.1], True),
        # The diagonal is 0.6 m or a little less or more than tolerated.
        ((30 / TOLERANCE * 1.03, 40 / TOLERANCE * 1.03), [1.0, 1.1], False),
        ((30 / TOLERANCE * 0.97, 40 / TOLERANCE * 0.97), [1.0, 1.1], True),
    ],
)
def test_straight_down_a_box_is_as_long_as_its_robot(size, length_m, refused):
    assert wrong(size, length_m) is refused


@pytest.mark.parametrize(("factor", "refused"), [(1.05, False), (0.95, True)])
def test_a_robot_seen_end_on_is_as_short_as_the_depression_makes_it(factor, refused):
    # 30 deg down from 20 m: 40 m away, 25 px a metre; 2 m seen end-on are 1 m across.
    least = 25.0 / TOLERANCE * factor
    assert wrong((0.1, least), [2.0, 2.0], down_deg=30.0) is refused
    assert wrong((2.0 * 25.0 * TOLERANCE / factor, 1.0), [2.0, 2.0], down_deg=30.0) is refused


@pytest.mark.parametrize(("size", "refused"), [((20, 0.1), True), ((0.1, 20), False)])
def test_a_flat_box_is_shorter_on_the_water_than_an_upright_one(size, refused):
    # 30 deg down from 20 m: 20 px are 0.8 m across the line of sight, and 1.6 m along it.
    assert wrong(size, [2.0, 2.0], down_deg=30.0) is refused


def test_a_box_that_may_be_cut_off_can_be_too_long_but_not_too_short():
    small, large = (4, 4), (300, 8)
    assert wrong(small, [1.0, 1.0])
    assert not wrong(small, [1.0, 1.0], center=(1000.0, 4.0))
    assert not wrong(small, [1.0, 1.0], center=(1996.0, 500.0))
    assert wrong(large, [1.0, 1.0], center=(1000.0, 4.0))


def test_what_is_uncertain_refuses_less():
    size = (100, 10)  # twice as long as allowed
    assert wrong(size, [1.0, 1.0])
    assert not wrong(size, [1.0, 1.0], more={"noise": {"height_m": 6.0}})
    assert not wrong((10, 1), [0.1, 0.1], more={"noise": {"box_center_px": 5.0}})
    assert not wrong((50, 5), [1.0, 1.0], down_deg=30.0, more={"noise": {"gimbal_pitch_deg": 6.0}})
    assert wrong((50, 5), [1.0, 1.0], down_deg=30.0)


def recorded_boxes(flight, length_m):
    """Return by class how many boxes of a recorded flight are refused, and of how many."""
    with (flight / "telemetry.csv").open() as stream:
        rows = {row["frame_no"]: row for row in csv.DictReader(stream)}
    with (flight / "boxes.csv").open() as stream:
        drawn = [row for row in csv.DictReader(stream) if row["class"] and row["frame_no"] in rows]
    classes = {row["class"] for row in drawn}
    config = estimator_config({f"classes.{name}.length_m": length_m for name in classes})
    focal = 2950.0  # at 3840 px, which the recordings do not state
    camera = CameraModel.from_camera_info(
        3840, 2160, "plumb_bob", [], [focal, 0, 1920.0, 0, focal, 1080.0, 0, 0, 1.0]
    )
    counts = {name: [0, 0] for name in classes}
    for row in drawn:
        reported = rows[row["frame_no"]]
        down, above = (
            float(reported[name]) for name in ("gimbal_pitch_down_deg", "height_above_takeoff_m")
        )
        matrix = matrix_from_rpy(0.0, math.radians(down), 0.0)
        pose = CameraPose(0, 0.9, 0.1, above, math.nan, matrix)
        left, top, *size = (float(row[name]) for name in ("x_px", "y_px", "width_px", "height_px"))
        center = np.array([[left + 0.5 * size[0], top + 0.5 * size[1]]])
        boxes = DetectionFrame(0, "camera", center, np.array([size]), np.ones(1), (row["class"],))
        points = locate(pose, camera, center, config.noise, config)
        if points.valid[0]:
            fit = SizeCheck(config).fit(PosedFrame(boxes, camera, pose, UNASKED), points)
            counts[row["class"]][0] += int(wrong_size(fit, points.valid)[0])
            counts[row["class"]][1] += 1
    return counts


@pytest.mark.parametrize("name", ["NorthSea_Fri_DJI_0113", "NorthSea_Fri_DJI_0114"])
def test_recorded_buoys_are_two_metres_long_and_boats_are_not(shared_data, name):
    flight = shared_data / "real_water" / "flights" / name
    if not flight.is_dir():
        pytest.skip(f"needs the recorded flight {name}")
    counts = recorded_boxes(flight, [1.8, 2.3])
    assert counts["buoy"][0] == 0
    assert counts["buoy"][1] > 70
    assert counts["boat"][0] > 0.7 * counts["boat"][1]


def test_other_classes_have_any_length():
    config = estimator_config({"classes": {"buoy": {"length_m": [0.1, 0.1]}}})
    pose = CameraPose(0, 0.9, 0.1, 20.0, math.nan, matrix_from_rpy(0.0, math.pi / 2, 0.0))
    boxes = DetectionFrame(
        0, "camera", np.full((2, 2), 500.0), np.full((2, 2), 400.0), np.ones(2), ("aqua", "buoy")
    )
    points = locate(pose, CAMERA, boxes.centers, config.noise, config)
    fit = SizeCheck(config).fit(PosedFrame(boxes, CAMERA, pose, UNASKED), points)
    assert wrong_size(fit, points.valid).tolist() == [False, True]
    assert fit.shortfall[0] == fit.excess[0] == -math.inf
    assert not SizeCheck(estimator_config({})).used


def test_a_point_that_is_refused_is_not_refused_again():
    assert not wrong((400, 400), [0.1, 0.1], down_deg=-45.0)
