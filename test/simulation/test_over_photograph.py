# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots drawn into a photograph are where they are labelled, and the rest stays a photograph."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.simulation.develop import as_levels, as_light
from aerial_gnss_ros.simulation.hexapod import RobotState
from aerial_gnss_ros.simulation.over_photograph import PhotographRenderer, matching_gain
from aerial_gnss_ros.simulation.renderer import Renderer
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.view import ViewPose, Window

CALM = replace(Scene(), noise=0.0, blur_px=0.0, vignette=0.0, whitecaps=0.0)
MATRIX = np.array([[700.0, 0.0, 320.0], [0.0, 700.0, 240.0], [0.0, 0.0, 1.0]])
CAMERA = CameraModel(640, 480, "plumb_bob", MATRIX, np.zeros(5))
POSE = ViewPose(np.array([0.0, 0.0, 7.0]), np.asarray(matrix_from_rpy(0.0, np.pi / 2, 0.0)))
PART = Window(200, 120, 240, 240)


def photograph(seed=3):
    """Brown water with some texture."""
    rng = np.random.default_rng(seed)
    texture = rng.integers(-12, 13, (240, 240, 1))
    return np.clip(np.array([60, 90, 100]) + texture, 0, 255).astype(np.uint8)


def robot(depth, east=0.0, north=0.0):
    return RobotState("aqua_01", east, north, 0.6, depth, speed=0.0)


def drawn(*robots, image=None, **how):
    image = photograph() if image is None else image
    return PhotographRenderer(CALM).draw_into(
        image, CAMERA, POSE, 3.0, robots, window=PART, softness_px=0.0, **how
    )


def test_light_and_levels_are_inverse():
    levels = np.arange(256, dtype=np.uint8).reshape(1, -1, 1).repeat(3, axis=2)
    light = as_light(levels)
    assert (np.diff(light[0, :, 0]) > 0.0).all()
    assert light[0, 188, 0] == pytest.approx(0.5029, abs=0.003)  # IEC 61966-2-1
    np.testing.assert_allclose(as_levels(light).astype(int), levels, atol=1)


def test_without_anything_it_is_the_photograph():
    image, labels = drawn()
    np.testing.assert_array_equal(image, photograph())
    assert labels == []


def test_a_robot_changes_what_is_in_its_box_and_is_labelled_as_if_rendered():
    image, (label,) = drawn(robot(0.0))
    _, (rendered,) = Renderer(CALM).render(CAMERA, POSE, 3.0, [robot(0.0)], (), PART)
    assert label.xywh == rendered.xywh
    changed = np.abs(image.astype(int) - photograph()).max(axis=-1)
    left, top = round(label.left) - PART.x, round(label.top) - PART.y
    inside = slice(top, top + round(label.xywh[3])), slice(left, left + round(label.xywh[2]))
    assert changed[inside].mean() > 30
    assert np.median(changed) == 0
    assert changed[:20].max() < 10  # its shadow at most
    rows, columns = np.nonzero(changed > 60)
    u, v = label.xywh[0] - PART.x, label.xywh[1] - PART.y
    assert (columns.mean(), rows.mean()) == pytest.approx((u, v), abs=0.15 * label.long_px)
    assert label.contrast > 0.1


def test_deeper_robots_take_the_colour_of_the_water_and_keep_its_texture():
    shallow, deep = (drawn(robot(depth))[1][0].contrast for depth in (0.1, 1.2))
    assert 0.0 < deep < 0.75 * shallow
    image, (label,) = drawn(robot(1.2))
    x, y = round(label.xywh[0]) - PART.x, round(label.xywh[1]) - PART.y
    here = slice(y - 6, y + 7), slice(x - 6, x + 7)
    texture = [np.ravel(one[here][..., 1]).astype(float) for one in (image, photograph())]
    assert np.corrcoef(*texture)[0, 1] > 0.5
    above, (label,) = drawn(robot(-0.2))
    x, y = round(label.xywh[0]) - PART.x, round(label.xywh[1]) - PART.y
    here = slice(y - 3, y + 4), slice(x - 3, x + 4)
    assert above[here].astype(float).std() < 0.5 * photograph()[here].astype(float).std()


def test_its_exposure_is_the_photograph_s():
    sea = [np.full((4, 4), 0.1, np.float32)] * 3
    level = np.full((8, 8, 3), as_levels(np.float32(0.07)), np.uint8)
    assert matching_gain(level, sea) == pytest.approx(0.7, rel=0.05)
    assert matching_gain(level, sea, 2.0) == pytest.approx(1.4, rel=0.05)
    # No camera makes a white sheet black, or burns it out by far.
    assert matching_gain(np.zeros_like(level), sea) == pytest.approx(0.3)
    assert matching_gain(np.full_like(level, 255), sea) == pytest.approx(2.0)
    dark = (photograph() * 0.7).astype(np.uint8)
    over = robot(-0.25)
    bright, (box,) = drawn(over)
    dim, _ = drawn(over, image=dark)
    x, y = round(box.xywh[0]) - PART.x, round(box.xywh[1]) - PART.y
    assert dim[y, x].mean() < 0.9 * bright[y, x].mean()
