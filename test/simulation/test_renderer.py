# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rendered images show robots where an independent projection puts them, and the horizon too."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL, matrix_from_rpy
from aerial_gnss_ros.simulation.hexapod import RobotState
from aerial_gnss_ros.simulation.renderer import Renderer
from aerial_gnss_ros.simulation.robot_models import placed_robot
from aerial_gnss_ros.simulation.scene import Scene, random_scene
from aerial_gnss_ros.simulation.view import ViewPose, Window, optical_rays, project_points

LENSES = {
    "plumb_bob": [-0.21, 0.08, 0.001, -0.0007, 0.01],
    "rational_polynomial": [0.3, 0.05, 0.0005, -0.0004, 0.01, 0.5, 0.1, 0.01],
}
POSES = [(0.0, 90.0, 0.0), (4.0, 60.0, 130.0), (-7.0, 35.0, -60.0), (3.0, 18.0, 200.0)]
CLEAN = replace(Scene(), noise=0.0, blur_px=0.0, vignette=0.0)


def _camera(lens: str = "plumb_bob", width: int = 640, height: int = 480) -> CameraModel:
    k = [610.0, 0.0, 325.3, 0.0, 607.0, 236.8, 0.0, 0.0, 1.0]
    p = [610.0, 0.0, 325.3, 0.0, 0.0, 607.0, 236.8, 0.0, 0.0, 0.0, 1.0, 0.0]
    return CameraModel.from_camera_info(
        width, height, lens, LENSES[lens], k, np.eye(3).ravel(), p, rectified=False
    )


def _pose(roll: float, down: float, yaw: float, height: float) -> ViewPose:
    rotation = matrix_from_rpy(np.radians(roll), np.radians(down), np.radians(yaw))
    return ViewPose(np.array([12.0, -30.0, height]), np.asarray(rotation))


def _aim(camera: CameraModel, pose: ViewPose, pixel: tuple[float, float]) -> np.ndarray:
    """The point of the water at a pixel."""
    rays, _ = camera.rays(np.array([pixel]))
    ray = pose.enu_from_camera @ FLU_FROM_OPTICAL @ rays[0]
    return np.asarray(pose.position - ray * pose.position[2] / ray[2])


def _opencv(camera: CameraModel, pose: ViewPose, points: np.ndarray) -> np.ndarray:
    turn = (pose.enu_from_camera @ FLU_FROM_OPTICAL).T
    rotation, _ = cv2.Rodrigues(turn)
    shift = -turn @ pose.position
    pixels, _ = cv2.projectPoints(points, rotation, shift, camera.K, np.asarray(camera.D))
    return np.asarray(pixels.reshape(-1, 2))


@pytest.mark.parametrize("lens", sorted(LENSES))
@pytest.mark.parametrize("angles", POSES)
def test_projection_agrees_with_opencv(lens: str, angles: tuple[float, float, float]) -> None:
    """Points of a robot above water, and crossings of submerged ones (to 0.1 px; here 0.001)."""
    camera, pose = _camera(lens), _pose(*angles, height=20.0)
    spot = _aim(camera, pose, (150.0, 330.0))
    mesh = placed_robot(RobotState("aqua_1", spot[0], spot[1], 0.8, depth=-0.3))
    assert mesh.vertices[:, 2].min() > 0.0
    pixels, valid = project_points(camera, pose, mesh.vertices)
    assert valid.all()
    np.testing.assert_allclose(pixels, _opencv(camera, pose, mesh.vertices), atol=1e-3)


@pytest.mark.parametrize("lens", sorted(LENSES))
def test_rays_of_the_image_are_the_lens_inverse(lens: str) -> None:
    """Projecting the interpolated ray of each pixel gives that pixel, to the edges."""
    camera = _camera(lens, 642, 479)
    rays = optical_rays(camera, Window(0, 0, 642, 479))
    v, u = np.mgrid[0:479:7, 0:642:7]
    pixels, _ = cv2.projectPoints(
        rays[v, u].reshape(-1, 3).astype(np.float64),
        np.zeros(3), np.zeros(3), camera.K, np.asarray(camera.D),
    )  # fmt: skip
    wanted = np.stack([u, v], axis=-1).reshape(-1, 2)
    np.testing.assert_allclose(pixels.reshape(-1, 2), wanted, atol=0.02)


@pytest.mark.parametrize("angles", POSES)
@pytest.mark.parametrize("depth", [-0.3, 0.0, 0.35])
def test_boxes_are_the_bounds_of_what_changes_in_the_image(
    angles: tuple[float, float, float], depth: float
) -> None:
    """What a robot changes in an otherwise equal picture, four times as fine, spans its box."""
    camera, pose = _camera(), _pose(*angles, height=6.0)
    spot = _aim(camera, pose, (300.0, 260.0))
    # No sun: no shadow and no glint; speed 0: no wake; flat sea: no wobble.
    scene = replace(CLEAN, sun_light=0.0, wind_speed=0.0, swell_slope=0.0, whitecaps=0.0)
    robot = RobotState("aqua_1", spot[0], spot[1], 2.0, depth=depth, speed=0.0, livery="white")
    renderer = Renderer(scene)
    _, labels = renderer.render(camera, pose, 1.0, [robot])
    label = labels[0]
    fine = _finer(camera, 4)
    window = Window(4 * int(label.left) - 60, 4 * int(label.top) - 60, 520, 520)
    empty, _ = renderer.render(fine, pose, 1.0, [], (), window)
    image, _ = renderer.render(fine, pose, 1.0, [robot], (), window)
    changed = cv2.absdiff(empty, image)
    rows, columns = np.nonzero(changed.max(axis=-1) > 3)
    left, right = (columns.min() + window.x) / 4 - 0.5, (columns.max() + 1 + window.x) / 4 - 0.5
    top, bottom = (rows.min() + window.y) / 4 - 0.5, (rows.max() + 1 + window.y) / 4 - 0.5
    measured = (left, top, right, bottom)
    box = (label.left, label.top, label.right, label.bottom)
    np.testing.assert_allclose(box, measured, atol=0.5)
    assert label.contrast == pytest.approx(changed[rows, columns].mean() / 255.0, rel=0.15)
    assert label.visible == pytest.approx(1.0)


def _finer(camera: CameraModel, times: int) -> CameraModel:
    """The same lens over pixels a fraction of the size; the image's edges stay."""
    k = camera.K * np.array([[times], [times], [1.0]])
    k[:2, 2] = times * (camera.K[:2, 2] + 0.5) - 0.5
    return replace(camera, width=times * camera.width, height=times * camera.height, K=k)


def test_robot_cut_by_the_edge_and_behind_another() -> None:
    """The box ends at the image's edge, and the visible share says how much is missing."""
    camera = CameraModel.from_camera_info(
        640, 480, "plumb_bob", [0.0] * 5, [600, 0, 319.5, 0, 600, 239.5, 0, 0, 1],
        np.eye(3).ravel(), [600, 0, 319.5, 0, 0, 600, 239.5, 0, 0, 0, 1, 0], rectified=False,
    )  # fmt: skip
    pose = _pose(0.0, 90.0, 0.0, 5.0)
    # Straight down with yaw 0 the image's right is south: the edge lies 320/600*5 m south.
    edge = pose.position[1] - 320.0 / 600.0 * 5.0
    half = RobotState("aqua_1", pose.position[0], edge, 0.0, depth=0.0, speed=0.0)
    under = RobotState("aqua_2", pose.position[0], pose.position[1], 0.0, depth=0.3, speed=0.0)
    over = RobotState("aqua_3", pose.position[0], pose.position[1], 0.0, depth=-0.1, speed=0.0)
    _, labels = Renderer(CLEAN).render(camera, pose, 0.0, [half, under, over])
    by_id = {label.robot_id: label for label in labels}
    assert by_id["aqua_1"].right == 639.5
    assert by_id["aqua_1"].visible == pytest.approx(0.5, abs=0.04)
    assert by_id["aqua_3"].visible == 1.0
    assert ("aqua_2" not in by_id) or by_id["aqua_2"].visible < 0.2


@pytest.mark.parametrize("down", [10.0, 3.0, -4.0])
def test_horizon_lies_where_geometry_says(down: float) -> None:
    """Sky ends and sea begins at the row of the horizontal ray (pinhole: cy - f tan(down))."""
    camera = CameraModel.from_camera_info(
        640, 480, "plumb_bob", [0.0] * 5, [600, 0, 319.5, 0, 600, 239.5, 0, 0, 1],
        np.eye(3).ravel(), [600, 0, 319.5, 0, 0, 600, 239.5, 0, 0, 0, 1, 0], rectified=False,
    )  # fmt: skip
    scene = replace(CLEAN, cloud_cover=0.0, sun_light=0.0, visibility_m=1e9, wind_speed=3.0)
    image, _ = Renderer(scene).render(camera, _pose(0.0, down, 40.0, 30.0), 0.0, [])
    rows = image.astype(np.float64).mean(axis=(1, 2))
    # The sea reflects the higher, darker sky: the largest step down the image is the horizon.
    step = int(np.argmax(rows[:-1] - rows[1:]))
    assert step + 0.5 == pytest.approx(239.5 - 600.0 * np.tan(np.radians(down)), abs=1.5)


def test_same_seed_same_bytes_whatever_came_before() -> None:
    """A frame does not depend on earlier frames, on the renderer's age or on OpenCV's threads."""
    scene = random_scene(np.random.default_rng(8))
    camera, pose = _camera(), _pose(2.0, 50.0, 10.0, 12.0)
    spot = _aim(camera, pose, (320.0, 240.0))
    robots = [RobotState("aqua_1", spot[0], spot[1], 0.3, depth=0.1)]
    used = Renderer(scene)
    used.render(camera, _pose(0.0, 80.0, 50.0, 40.0), 7.7, [])
    first, first_labels = used.render(camera, pose, 3.2, robots)
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    second, second_labels = Renderer(scene).render(camera, pose, 3.2, robots)
    cv2.setNumThreads(threads)
    np.testing.assert_array_equal(first, second)
    assert first_labels == second_labels
    other, _ = used.render(camera, pose, 3.3, robots)
    assert (other != first).mean() > 0.2  # the sea moves


def test_window_shows_the_same_as_the_whole_image() -> None:
    """A window is the crop of the image (lens softness apart), and labels keep image pixels."""
    scene = replace(CLEAN, whitecaps=0.0)
    camera, pose = _camera(), _pose(2.0, 50.0, 10.0, 12.0)
    spot = _aim(camera, pose, (320.0, 240.0))
    robots = [RobotState("aqua_1", spot[0], spot[1], 0.3, depth=0.1)]
    renderer = Renderer(scene)
    whole, labels = renderer.render(camera, pose, 3.2, robots)
    part, part_labels = renderer.render(camera, pose, 3.2, robots, (), Window(200, 150, 240, 200))
    difference = cv2.absdiff(whole[150:350, 200:440], part)
    assert np.quantile(difference, 0.999) <= 3
    assert part_labels[0].xywh == pytest.approx(labels[0].xywh, abs=1e-6)


def test_deeper_robots_fade() -> None:
    """Contrast falls with depth and is gone where the water lets nothing through."""
    camera, pose = _camera(), _pose(0.0, 70.0, 0.0, 10.0)
    spot = _aim(camera, pose, (320.0, 240.0))
    scene = replace(CLEAN, sun_light=0.0, attenuation=(0.8, 0.6, 0.9), wind_speed=2.0)
    renderer = Renderer(scene)
    contrasts = []
    for depth in (0.0, 0.5, 1.5, 6.0):
        robot = RobotState("aqua_1", spot[0], spot[1], 0.3, depth=depth, speed=0.0)
        _, labels = renderer.render(camera, pose, 0.0, [robot])
        contrasts.append(labels[0].contrast)
    assert contrasts == sorted(contrasts, reverse=True)
    assert contrasts[0] > 0.1
    assert contrasts[-1] < 0.01
