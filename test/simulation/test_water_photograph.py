# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Photographed water stays on the water's plane while the camera moves, with robots in it."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.hexapod import RobotState
from aerial_gnss_ros.simulation.renderer import Renderer
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.view import ViewPose, project_points
from aerial_gnss_ros.simulation.water_photograph import WaterPhotograph, WaterRenderer, coloured

CALM = replace(Scene(seed=5), noise=0.0, blur_px=0.0, whitecaps=0.0)
MATRIX = np.array([[500.0, 0.0, 320.0], [0.0, 500.0, 180.0], [0.0, 0.0, 1.0]])
CAMERA = CameraModel(640, 360, "plumb_bob", MATRIX, np.zeros(5))
RED = (30, 30, 220)
WIDTH_M = 12.0


def pose(east, height, pitch_deg):
    return ViewPose(
        np.array([east, 0.0, height]), np.asarray(matrix_from_rpy(0.0, np.radians(pitch_deg), 0.0))
    )


def photograph(spot=(200, 150)):
    image = np.full((300, 400, 3), (90, 80, 40), np.uint8)
    cv2.circle(image, spot, 9, RED, -1)
    return WaterPhotograph(image, WIDTH_M)


def spots(image):
    """Return the middles (n, 2) px of red spots, the largest first."""
    red = (image[..., 2] > 150) & (image[..., 1] < 110)
    count, _, stats, middles = cv2.connectedComponentsWithStats(red.astype(np.uint8))
    order = np.argsort(-stats[1:, cv2.CC_STAT_AREA])
    return middles[1:][order][: count - 1]


def place(view, pixel):
    """Return where on the water (2,) a pixel is."""
    ray = view.enu_from_optical @ CAMERA.rays(pixel[None])[0][0]
    return (view.position - ray * view.position[2] / ray[2])[:2]


def test_what_is_in_the_photograph_stays_on_the_water():
    """Seen from two places and tilts, and as large as the photograph's scale says."""
    views = [pose(0.0, 25.0, 80.0), pose(-6.0, 18.0, 60.0)]
    renderer = WaterRenderer(CALM, photograph())
    seen = [[place(view, one) for one in spots(renderer.render(CAMERA, view, 3.0, [])[0])]
            for view in views]  # fmt: skip
    common = [a for a in seen[0] if any(np.linalg.norm(a - b) < 0.15 for b in seen[1])]
    assert len(common) >= 2
    spans = [np.linalg.norm(a - b) for a in seen[0] for b in seen[0] if a is not b]
    # The spot is in the photograph's middle: its mirror images are a width or a height apart.
    assert min(spans) == pytest.approx(9.0, abs=0.1)


def test_far_water_is_averaged_not_sampled():
    rng = np.random.default_rng(1)
    noisy = WaterPhotograph(rng.integers(40, 200, (300, 400, 3), dtype=np.uint8), WIDTH_M)
    image, _ = WaterRenderer(CALM, noisy).render(CAMERA, pose(0.0, 25.0, 35.0), 3.0, [])
    near, far = image[-60:].astype(float).std(), image[:60].astype(float).std()
    assert far < 0.5 * near
    assert image[:60].mean() == pytest.approx(120.0, abs=12.0)


def test_robots_are_labelled_as_if_rendered_and_seen():
    view, robot = pose(0.0, 8.0, 70.0), RobotState("aqua_1", 2.0, 0.5, 0.6, 0.0, speed=0.0)
    image, (label,) = WaterRenderer(CALM, photograph()).render(CAMERA, view, 3.0, [robot])
    _, (rendered,) = Renderer(CALM).render(CAMERA, view, 3.0, [robot])
    assert label.xywh == rendered.xywh
    empty, _ = WaterRenderer(CALM, photograph()).render(CAMERA, view, 3.0, [])
    middle, _ = project_points(CAMERA, view, np.array([[2.0, 0.5, 0.0]]))
    u, v = np.round(middle[0]).astype(int)
    changed = np.abs(image.astype(int) - empty).max(axis=-1)
    assert changed[v - 5 : v + 6, u - 5 : u + 6].mean() > 20
    assert np.median(changed) == 0


def test_the_sky_is_rendered():
    image, _ = WaterRenderer(CALM, photograph()).render(CAMERA, pose(0.0, 8.0, 5.0), 3.0, [])
    assert image[:40].mean() > image[-40:].mean() + 25


def test_its_water_has_the_photograph_s_hue():
    brown = np.full((80, 80, 3), (40, 80, 110), np.uint8)
    blue, green, red = coloured(CALM, brown).water_colour
    assert blue < green < red


def test_another_seed_is_another_part_of_the_photograph():
    one, other = (
        WaterRenderer(replace(CALM, seed=seed), photograph()).render(
            CAMERA, pose(0.0, 25.0, 80.0), 3.0, []
        )[0]
        for seed in (5, 6)
    )
    assert (one != other).any()


@pytest.mark.parametrize(("side", "width_m", "said"), [(40, 30.0, "40x40"), (80, 0.0, "not 0")])
def test_what_is_too_small_is_refused(side, width_m, said):
    with pytest.raises(ConfigError, match=said):
        WaterPhotograph(np.zeros((side, side, 3), np.uint8), width_m)
