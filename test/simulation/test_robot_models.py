# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The models have their stated size, on the mesh and in the image, and look different."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.hexapod import LIVERIES, RobotState
from aerial_gnss_ros.simulation.renderer import Renderer
from aerial_gnss_ros.simulation.robot_models import MODELS, robot_model
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.view import ViewPose

OTHERS = ("torpedo", "box", "catamaran")
FOCAL_PX, HEIGHT_M = 1000.0, 8.0
# Diffuse light and flat water: nothing changes the image but the robot itself.
CALM = replace(
    Scene(), sun_light=0.0, wind_speed=0.0, swell_slope=0.0, whitecaps=0.0, noise=0.0,
    blur_px=0.0, vignette=0.0,
)  # fmt: skip


def _seen(model: str, course: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return the image of a robot straight below, and which pixels it changes."""
    k = [FOCAL_PX, 0.0, 159.5, 0.0, FOCAL_PX, 159.5, 0.0, 0.0, 1.0]
    camera = CameraModel(320, 320, "plumb_bob", np.array(k).reshape(3, 3), np.zeros(5))
    pose = ViewPose(np.array([0.0, 0.0, HEIGHT_M]), np.asarray(matrix_from_rpy(0.0, np.pi / 2, 0)))
    robot = RobotState("r", 0.0, 0.0, course, speed=0.0, livery="white", model=model)
    renderer = Renderer(CALM)
    image, _ = renderer.render(camera, pose, 0.0, [robot])
    empty, _ = renderer.render(camera, pose, 0.0, [])
    return image, cv2.absdiff(image, empty).max(axis=-1) > 8


@pytest.mark.parametrize("name", OTHERS)
def test_the_mesh_has_the_stated_size_and_every_livery(name: str) -> None:
    model = MODELS[name]
    for livery in LIVERIES.values():
        span = np.ptp(model.build(0.0, livery).vertices, axis=0)
        np.testing.assert_allclose(span, model.size, rtol=0.03)


@pytest.mark.parametrize("name", OTHERS)
def test_the_image_shows_the_stated_length_and_width(name: str) -> None:
    """Seen from straight above, to 6 %: what stands out of the water is a little nearer."""
    model = MODELS[name]
    _, changed = _seen(name)
    rows, columns = np.nonzero(changed)
    metres = HEIGHT_M / FOCAL_PX
    # The camera's top is east, where the nose points.
    assert metres * (np.ptp(rows) + 1) == pytest.approx(model.length, rel=0.06)
    assert metres * (np.ptp(columns) + 1) == pytest.approx(model.width, rel=0.06)


def test_the_models_look_different() -> None:
    """No two outlines at the same length share more than 80 % of their area."""
    shapes = {}
    for name in MODELS:
        _, changed = _seen(name)
        rows, columns = np.nonzero(changed)
        side = np.ptp(rows) + 1
        left = int(columns.mean() - side / 2)
        part = changed[rows.min() : rows.max() + 1, max(left, 0) : left + side].astype(np.uint8)
        shapes[name] = cv2.resize(part, (64, 64), interpolation=cv2.INTER_AREA) > 0
    for one in MODELS:
        for other in MODELS:
            both, either = shapes[one] & shapes[other], shapes[one] | shapes[other]
            assert one == other or both.sum() / either.sum() < 0.8, (one, other)


def test_an_unknown_model_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"no robot model 'whale'; choose one of aqua, torpedo"):
        robot_model("whale")
