# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What surrounds a result: pixels of robots where their boxes are, depths, references."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.estimation.overview import robot_pixels
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.georeferencing.localization import locate
from aerial_gnss_ros.core.values.rejection import Reason

BUOY = {"class": "buoy", "position": [13.2, -59.6], "sigma_m": 0.1}
REFERENCES = {f"references.buoy.{key}": value for key, value in BUOY.items()}


def flown(sea, **values):
    engine = sea.estimator(values)
    world = sea.World(robots={"a": lambda _t: (3.0, 12.0), "b": lambda _t: (-4.0, 16.0)})
    return engine, world, sea.play(engine, world, 3.0)


def test_robots_are_drawn_where_their_boxes_are(sea):
    engine, world, results = flown(sea)
    last = next(one for one in reversed(results) if len(one.estimates) == 2)
    seen = engine.overview(last)
    boxes = world.frame((last.stamp_ns - results[0].stamp_ns) * 1e-9).centers
    for pixel in seen.pixels:
        assert min(np.hypot(*(boxes - pixel).T)) < 1.0
    assert np.hypot(*(seen.pixels[0] - seen.pixels[1])) > 20.0


def test_the_footprint_is_what_the_pose_and_the_camera_give(sea):
    engine, world, results = flown(sea)
    seen = engine.overview(results[-1])
    assert seen.image_size == (world.camera.width, world.camera.height)
    for robot in results[-1].estimates:
        low, high = seen.footprint.min(axis=0), seen.footprint.max(axis=0)
        assert (low < [robot.latitude, robot.longitude]).all()
        assert (high > [robot.latitude, robot.longitude]).all()


def test_depths_and_references_are_those_of_the_parameters(sea):
    values = {"depth.robots_m": 1.5, **REFERENCES}
    engine, _, results = flown(sea, **values)
    last = next(one for one in reversed(results) if one.estimates)
    seen = engine.overview(last)
    assert seen.depths.tolist() == [1.5] * len(last.estimates)
    (buoy,) = seen.references
    assert (buoy.name, math.degrees(buoy.latitude)) == ("buoy", pytest.approx(13.2))


def test_without_a_pose_there_is_no_footprint(sea):
    engine = sea.estimator()
    world = sea.World(robots={"a": lambda _t: (3.0, 12.0)})
    engine.add_detections(world.frame(0.0))
    (result,) = engine.flush()
    seen = engine.overview(result)
    assert result.rejections[0].reason is not Reason.BAD_DETECTIONS
    assert seen.footprint.shape == (0, 2)
    assert seen.image_size is None


def test_a_robot_under_water_is_drawn_where_refraction_shows_it(result_at):
    camera = CameraModel.from_focal_length(4e-3, 6e-3, None, 1200, 800)
    robots = result_at(7, ["deep"]).estimates
    pose = result_at(7).pose
    pose = replace(pose, enu_from_camera=matrix_from_rpy(0.0, math.radians(80.0), 0.4))
    depth = np.array([3.0])
    pixel = np.array([[700.0, 350.0]])
    point = locate(pose, camera, pixel, Noise(), depths=depth)
    robot = replace(robots[0], latitude=point.latitude[0], longitude=point.longitude[0])
    drawn = robot_pixels((robot,), depth, pose, camera)
    level = robot_pixels((robot,), np.zeros(1), pose, camera)
    assert np.hypot(*(drawn - pixel)[0]) < 1.0 < np.hypot(*(level - pixel)[0])
