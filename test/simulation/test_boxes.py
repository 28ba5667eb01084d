# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes without images agree with OpenCV; the simulated detector errs as stated."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL, matrix_from_rpy
from aerial_gnss_ros.simulation.boxes import Boxes, DetectorPlan, detected, projected_boxes
from aerial_gnss_ros.simulation.experiment import default_camera
from aerial_gnss_ros.simulation.view import ViewPose

CAMERA = default_camera(1280, 720)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("model", ["plumb_bob", "rational_polynomial"])
def test_middles_and_corners_agree_with_projectpoints(seed, model):
    """Tilted camera, distorted lens, robots afloat at any course."""
    rng = np.random.default_rng(seed)
    d = [-0.2, 0.05, 2e-3, -1e-3, 0.01] if model == "plumb_bob" else [
        0.3, 0.1, 1e-3, -2e-3, 0.01, 0.5, 0.15, 0.02,
    ]  # fmt: skip
    camera = CameraModel(1280, 720, model, CAMERA.K, np.array(d))
    rotation = matrix_from_rpy(*rng.uniform([-0.3, 0.6, -3.0], [0.3, 1.3, 3.0]))
    pose = ViewPose(np.array([3.0, -2.0, 14.0]), rotation)
    hit = pose.position - pose.position[2] / rotation[2, 0] * rotation[:, 0]
    places = np.column_stack([hit[:2] + rng.uniform(-3.0, 3.0, (6, 2)), np.full(6, 0.1)])
    courses = rng.uniform(-3.0, 3.0, 6)
    boxes = projected_boxes(camera, pose, tuple("abcdef"), ("aqua",) * 6, places, courses)
    optical_from_enu = (rotation @ FLU_FROM_OPTICAL).T
    rvec, _ = cv2.Rodrigues(optical_from_enu)
    tvec = -optical_from_enu @ pose.position
    assert len(boxes.names) >= 4
    for name, center, size in zip(boxes.names, boxes.centers, boxes.sizes, strict=True):
        i = "abcdef".index(name)
        c, s = math.cos(courses[i]), math.sin(courses[i])
        half = 0.5 * np.array([0.65, 0.45, 0.13])
        corners = (
            np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
            * half
            @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        )
        points = np.vstack([np.zeros(3), corners]) + places[i]
        pixels, _ = cv2.projectPoints(points, rvec, tvec, camera.K, camera.D)
        pixels = pixels.reshape(-1, 2)
        np.testing.assert_allclose(center, pixels[0], atol=1e-6)
        np.testing.assert_allclose(size, np.ptp(pixels[1:], axis=0), atol=1e-6)


def test_robots_outside_the_image_behind_it_or_deep_have_no_box():
    pose = ViewPose(np.array([0.0, 0.0, 10.0]), matrix_from_rpy(0.0, math.radians(45.0), 0.0))
    places = np.array([[10.0, 0.0, 0.0], [10.0, 30.0, 0.0], [-30.0, 0.0, 0.0], [10.0, 0.0, -0.7]])
    boxes = projected_boxes(CAMERA, pose, ("a", "b", "c", "d"), ("aqua",) * 4, places, np.zeros(4))
    assert boxes.names == ("a",)
    assert projected_boxes(CAMERA, pose, (), (), np.zeros((0, 3)), np.zeros(0)).names == ()


def test_detection_errors_have_the_stated_size_and_rates():
    boxes = Boxes(
        ("a", "b"), ("aqua",) * 2, np.array([[600.0, 300.0], [200.0, 500.0]]), np.full((2, 2), 40.0)
    )
    plan = DetectorPlan(center_px=3.0, missed=0.2, false_per_image=0.5)
    rng = np.random.default_rng(1)
    true, total, wrong = [], 0, 0
    for _ in range(3000):
        found = detected(boxes, plan, CAMERA, "aqua", 5, "camera", rng)
        assert (np.diff(found.scores) <= 0).all()
        near = found.centers[:, None, :] - boxes.centers[None]
        hit = np.linalg.norm(near, axis=2).min(axis=1) < 18.0
        true.extend(near[i, np.linalg.norm(near[i], axis=1).argmin()] for i in np.flatnonzero(hit))
        total += hit.sum()
        wrong += (~hit).sum()
    assert total / 6000 == pytest.approx(0.8, abs=0.02)
    assert wrong / 3000 == pytest.approx(0.5, abs=0.05)
    np.testing.assert_allclose(np.std(true, axis=0), 3.0, rtol=0.05)


def test_nothing_seen_gives_an_empty_frame():
    none = Boxes((), (), np.zeros((0, 2)), np.zeros((0, 2)))
    found = detected(none, DetectorPlan(), CAMERA, "aqua", 5, "camera", np.random.default_rng(1))
    assert len(found) == 0
    assert found.centers.shape == (0, 2)
