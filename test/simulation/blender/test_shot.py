# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is drawn: `unseen` shares no look with `train`, robots are where the window is."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.simulation.blender.hexapod import (
    GAITS,
    deck,
    flipper_halves,
    hip,
    hull,
    random_build,
)
from aerial_gnss_ros.simulation.blender.props import HARBOUR
from aerial_gnss_ros.simulation.blender.ranges import PAINTS, RANGES
from aerial_gnss_ros.simulation.blender.shot import random_shot
from aerial_gnss_ros.simulation.blender.tracing import Outline, box, in_window, refracted
from aerial_gnss_ros.simulation.refraction import apparent_points
from aerial_gnss_ros.simulation.robot_models import MODELS
from aerial_gnss_ros.simulation.scene import WATERS
from aerial_gnss_ros.simulation.staging import Variety
from aerial_gnss_ros.simulation.view import Window, project_points


def test_unseen_shares_no_range_with_train() -> None:
    """Colours, gaits, waters and spectra differ; wind and sun lie in spans that do not overlap."""
    train, unseen = RANGES["train"], RANGES["unseen"]
    for key, known in (("paints", PAINTS), ("gaits", GAITS), ("waters", WATERS)):
        assert not set(getattr(train, key)) & set(getattr(unseen, key)), key
        assert set(getattr(train, key)) | set(getattr(unseen, key)) <= set(known), key
    assert not set(train.spectra) & set(unseen.spectra)
    assert train.props != unseen.props
    for key in ("wind_mps", "sun_elevation_deg"):
        for low, high in getattr(train, key):
            assert all(high <= a or b <= low for a, b in getattr(unseen, key)), key


@pytest.mark.parametrize("name", sorted(RANGES))
def test_the_first_robot_is_in_the_window(name: str) -> None:
    """And is within its range of depths, in a look of its ranges."""
    ranges, variety = RANGES[name], Variety(depth_m=(0.1, 0.6))
    for seed in range(20):
        rng = np.random.default_rng(seed)
        shot = random_shot(rng, ranges, (320, 240), 1.0, None, variety)
        robot, window = shot.robots[0], shot.view.window
        place = np.array([[robot.east, robot.north, 0.0]])
        pixel, _ = project_points(shot.view.camera, shot.view.pose, place)
        assert in_window(pixel, window).all()
        assert 0.08 <= robot.depth <= 0.6
        assert len(robot.flippers) == 6
        assert any(lo <= shot.scene.wind_speed <= hi for lo, hi in ranges.wind_mps)


def test_refraction_agrees_with_the_flat_crossing() -> None:
    """A ray to where a submerged point appears goes on, bent, to the point itself."""
    camera = np.array([0.0, 0.0, 12.0])
    points = np.array([[3.0, 1.0, -0.8], [0.1, 0.0, -0.3], [-9.0, 14.0, -1.0]])
    crossing = apparent_points(camera, points)
    rays = crossing - camera
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    bent = refracted(rays, np.tile([0.0, 0.0, 1.0], (3, 1)))
    below = points - crossing
    assert bent == pytest.approx(below / np.linalg.norm(below, axis=1, keepdims=True), abs=1e-6)


def test_a_box_ends_at_the_window() -> None:
    """Half a sight line's step is added on each side, and the window's edge cuts it."""
    pixels = np.array([[8.0, 4.0], [10.0, 6.0], [99.0, 5.0]])
    outline = Outline(pixels, 1.0, np.ones(3, dtype=bool))
    assert box(outline, Window(0, 0, 50, 50)) == (7.5, 3.5, 10.5, 6.5)
    assert box(outline, Window(9, 0, 1, 50)) is None
    assert box(outline, Window(10, 6, 50, 50)) == (9.5, 5.5, 10.5, 6.5)


@pytest.mark.parametrize("model", ["torpedo", "box", "catamaran"])
def test_robots_have_the_shape_that_is_asked_for(model: str) -> None:
    """Their mesh replaces the hexapod's; views fit their length."""
    variety = Variety(robot_model=model, usual=1.0, usual_long_px=(80.0, 80.0))
    shot = random_shot(np.random.default_rng(4), RANGES["train"], (320, 320), 1.0, None, variety)
    for robot in shot.robots:
        assert (robot.class_name, robot.robot_id[: len(model)]) == (model, model)
        assert robot.mesh is not None
        span = np.ptp(robot.mesh.vertices, axis=0)
        np.testing.assert_allclose(span, MODELS[model].size, rtol=0.03)
    first = shot.robots[0]
    near = np.linalg.norm([first.east, first.north, shot.view.height])
    pixels = shot.view.camera.K[0, 0] * MODELS[model].length / near
    assert pixels == pytest.approx(80.0, rel=1e-6)


def test_robots_are_of_an_aquas_size() -> None:
    """About 0.65 x 0.25 x 0.13 m without flippers, every face looking outward."""
    for seed in range(10):
        build = random_build(np.random.default_rng(seed), RANGES["train"])
        size = np.ptp(hull(build).vertices, axis=0)
        assert size == pytest.approx([0.65, 0.25, 0.13], rel=0.25)
        for mesh in (hull(build), hip(build), *flipper_halves(build), deck(build)[0]):
            corner = mesh.vertices[mesh.faces]
            volume = np.einsum("ij,ij->i", corner[:, 0], np.cross(corner[:, 1], corner[:, 2]))
            assert volume.sum() > 0.0


@pytest.mark.parametrize("kind", sorted(HARBOUR))
def test_things_of_the_harbour_have_sane_sizes(kind: str) -> None:
    """Centimetres to metres, colours of paint."""
    for seed in range(5):
        mesh = HARBOUR[kind](np.random.default_rng(seed))
        assert 0.2 < np.ptp(mesh.vertices, axis=0).max() < 5.0
        assert (mesh.colours >= 0.0).all()
        assert (mesh.colours <= 1.0).all()
