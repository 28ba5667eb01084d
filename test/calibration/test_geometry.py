# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Predicted boxes and their derivatives, against differences of the prediction itself."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.calibration.geometry import Boxes, on_water, predicted
from aerial_gnss_ros.calibration.motion import Poses
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy

CAMERA = CameraModel.from_camera_info(
    1280, 720, "plumb_bob", [-0.1, 0.02, 0.001, -0.0005, 0.0],
    [900.0, 0, 640.0, 0, 905.0, 360.0, 0, 0, 1.0],
)  # fmt: skip
PIXELS = np.array([[700.0, 300.0], [300.0, 500.0], [900.0, 200.0]])
STEP = 1e-6


def poses(position=0.0, turn=(0.0, 0.0, 0.0)):
    """Return three cameras that fly and turn, displaced and turned about East, North, Up."""
    ways = [(0.05, 0.9, 0.3), (-0.1, 1.2, 2.0), (0.02, 0.7, -1.0)]
    rotation = np.array([matrix_from_rpy(*one) for one in ways])
    place = np.array([[1.0, 2.0, 20.0], [-3.0, 4.0, 25.0], [5.0, -6.0, 15.0]])
    velocity = np.array([[3.0, 0.5, -0.2], [-1.0, 2.0, 0.3], [0.5, 0.5, 1.0]])
    turning = np.array([[0.1, -0.2, 0.3], [0.0, 0.1, -0.4], [0.2, 0.2, 0.1]])
    turned = Rotation.from_rotvec(np.array(turn)).as_matrix() @ rotation
    return Poses(place + position, turned, velocity, turning, np.ones(3, bool))


def boxes(depth=0.0, pixels=PIXELS):
    rays, _ = CAMERA.rays(pixels)
    every = np.arange(3)
    return Boxes(every, pixels, rays, np.full(3, depth), np.zeros(3, int), ((CAMERA, every),))


def values(depth=0.0, errors=0.0, places=0.0, focal=0.0, seen=None):
    """Return the prediction at the places where the boxes lie, displaced."""
    seen = seen or poses()
    at, _ = on_water(boxes(depth), poses())
    return predicted(boxes(depth), seen, np.zeros((3, 6)) + errors, at + places, focal)


@pytest.mark.parametrize("depth", [0.0, 1.5])
def test_a_box_is_predicted_where_it_is(depth):
    """On the water, and below it through the surface."""
    assert np.abs(values(depth).values).max() < 0.01  # the water is curved


@pytest.mark.parametrize("column", range(6))
def test_the_derivative_by_errors_of_the_pose_is_that_of_the_prediction(column):
    change = np.zeros(6)
    change[column] = STEP
    moved = values(errors=-change).values - values(errors=change).values  # measured less predicted
    assert values().by_error[:, :, column] == pytest.approx(
        moved / (2.0 * STEP), rel=1e-4, abs=1e-3
    )


@pytest.mark.parametrize("column", range(2))
def test_the_derivative_by_a_robots_place_is_that_of_the_prediction(column):
    change = np.zeros(2)
    change[column] = STEP
    moved = values(places=-change).values - values(places=change).values
    assert values().by_place[:, :, column] == pytest.approx(
        moved / (2.0 * STEP), rel=1e-4, abs=1e-3
    )


def test_the_derivative_by_the_focal_length_is_that_of_the_prediction():
    moved = values(focal=-STEP).values - values(focal=STEP).values
    assert values().by_focal == pytest.approx(moved / (2.0 * STEP), rel=1e-5, abs=1e-4)


def test_telemetry_taken_earlier_shows_where_the_camera_was():
    def at(seconds, turns=True):
        now = poses()
        turn = np.array(now.turning) * seconds * turns
        rotation = Rotation.from_rotvec(turn).as_matrix() @ now.rotation
        return Poses(
            now.position + seconds * now.velocity, rotation, now.velocity, now.turning, now.known
        )

    moved = values(seen=at(STEP)).values - values(seen=at(-STEP)).values
    assert values().by_latency == pytest.approx(moved / (2.0 * STEP), rel=1e-4, abs=1e-3)
    moved = values(seen=at(-STEP, turns=False)).values - values(seen=at(STEP, turns=False)).values
    assert values().by_fix_delay == pytest.approx(moved / (2.0 * STEP), rel=1e-4, abs=1e-3)


def test_a_place_covers_more_pixels_the_nearer_and_the_steeper_it_is_seen():
    """Of the same pixel, by the determinant of the derivative by the place."""
    low = poses()
    high = poses(np.array([0.0, 0.0, 7.0]), (0.02, 0.01, 0.0))
    found = []
    for seen in (low, high):
        at, _ = on_water(boxes(), seen)
        one = predicted(boxes(), seen, np.zeros((3, 6)), at, 0.0)
        found.append((one.area, np.log(np.abs(np.linalg.det(one.by_place)))))
    assert found[1][0] - found[0][0] == pytest.approx(found[1][1] - found[0][1], abs=1e-6)


def test_rays_that_miss_the_water_meet_nothing():
    level = Poses(
        np.array([[0.0, 0.0, 20.0]]), np.eye(3)[None], np.zeros((1, 3)), np.zeros((1, 3)),
        np.array([True]),
    )  # fmt: skip
    pixels = np.array([[640.0, 300.0], [640.0, 370.0], [640.0, 450.0]])
    rays, _ = CAMERA.rays(pixels)
    zeros = np.zeros(3, int)
    places, reach = on_water(
        Boxes(zeros, pixels, rays, np.zeros(3), zeros, ((CAMERA, np.arange(3)),)), level
    )
    assert np.isnan(reach).tolist() == [True, True, False]  # the second is too near the horizon
    assert np.isnan(places[:2]).all()
    assert places[2] == pytest.approx([20.0 * 905.0 / 90.0, 0.0], rel=0.02, abs=0.3)


def test_some_boxes_keep_their_own_cameras():
    wide = CameraModel.from_focal_length(0.005, 0.0128, None, 1280, 720)
    rays = np.arange(9.0).reshape(3, 3)
    both = ((CAMERA, np.array([0, 2])), (wide, np.array([1])))
    every = np.arange(3)
    kept = Boxes(every, PIXELS, rays, every + 0.5, every, both).only(np.array([1, 2]))
    assert kept.pixels.tolist() == PIXELS[1:].tolist()
    assert (kept.depths.tolist(), kept.kinds.tolist()) == ([1.5, 2.5], [1, 2])
    assert [(camera is wide, rows.tolist()) for camera, rows in kept.cameras] == [
        (False, [1]), (True, [0]),
    ]  # fmt: skip
