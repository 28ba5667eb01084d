# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Things afloat in a flight: clear of the robots' whole paths and of one another."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.simulation.afloat import ROBOT_M, apart, gaps, outline, place_things
from aerial_gnss_ros.simulation.experiment import Experiment, default_camera
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.hexapod import hexapod
from aerial_gnss_ros.simulation.robot_models import placed_robot
from aerial_gnss_ros.simulation.scenario import scenario, words

SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
BAR = SQUARE * (3.0, 0.5)
"""6 m long, 1 m wide."""


def moved(shape, east: float, north: float):
    return shape + np.array([east, north])


def flown(kind: str, height: float, seed: int, distractors: int = 12) -> Experiment:
    plan = FlightPlan(kind=kind, duration_s=20.0, height_m=height)
    camera = default_camera(1280, 720)
    return Experiment(GeneratedFlight(plan, seed), camera, distractors=distractors, seed=seed)


@pytest.mark.parametrize(
    ("point", "gap"),
    [((3, 0), 2), ((0, -1.5), 0.5), ((0, 0), -1), ((0.75, 0.5), -0.25), ((2, 2), 1)],
)
def test_how_far_a_point_is_outside_a_square(point, gap):
    assert gaps(SQUARE, np.array([point], dtype=float)).tolist() == [gap]


@pytest.mark.parametrize(
    ("one", "other", "gap"),
    [
        (SQUARE, moved(SQUARE, 3, 0), 1),
        (SQUARE, moved(SQUARE, 1.5, 0), -0.5),
        (SQUARE, 0.1 * SQUARE, -1.1),  # within: to be moved out by its side too
        (BAR, BAR[:, ::-1][::-1], -3.5),  # a cross, no corner of one within the other
        (BAR, moved(BAR, 0, 1.25), 0.25),
        (SQUARE, moved(SQUARE, 4, 5), 3),
    ],
)
def test_how_far_two_outlines_are_apart(one, other, gap):
    assert apart(one, other) == pytest.approx(gap)
    assert apart(other, one) == pytest.approx(gap)


def test_a_robot_reaches_less_far_than_is_kept_clear():
    reach = [np.hypot(*hexapod(p).vertices[:, :2].T).max() for p in np.linspace(0, 2 * np.pi, 60)]
    assert 0.5 < max(reach) < ROBOT_M - 0.1


@pytest.mark.parametrize(
    ("kind", "height", "seed"), [("hover", 5, 1), ("orbit", 8, 2), ("transit", 6, 3)]
)
def test_no_thing_touches_a_robot_or_another_thing_in_any_image(kind, height, seed):
    """By the areas that the meshes have in common, which OpenCV works out."""
    made = flown(kind, height, seed)
    assert len(made.props) > 4
    things = [outline(thing).astype(np.float32) for thing in made.props]
    for i, thing in enumerate(things):
        for other in things[:i]:
            assert cv2.intersectConvexConvex(thing, other)[0] == 0.0
    for frame in made.frames()[::5]:
        for state in made.states(frame):
            robot = outline(placed_robot(state)).astype(np.float32)
            assert all(cv2.intersectConvexConvex(robot, thing)[0] == 0.0 for thing in things)


def test_things_are_where_the_camera_sees_them():
    made = flown("hover", 15.0, 4, distractors=8)
    frame = made.frames()[0]
    middles = np.array([thing.vertices.mean(axis=0) for thing in made.props])
    offset = (middles - frame.pose.position) @ frame.pose.enu_from_optical
    pixels, _ = made.camera.project(offset)
    assert len(pixels) == 8
    assert made.camera.inside(pixels).all()


def test_where_there_is_no_room_there_are_fewer_and_it_is_said():
    made = flown("hover", 5.0, 1, distractors=0)
    everywhere = np.stack(np.meshgrid(*2 * [np.arange(-40.0, 40.0)]), axis=-1).reshape(-1, 2)
    rng = np.random.default_rng(1)
    assert place_things(made.flight, made.camera, 5, everywhere, rng) == ()

    crowded = flown("hover", 3.0, 1, distractors=20)
    placed = len(crowded.props)
    assert 0 < placed < 20
    about = scenario(crowded, "none")
    assert (about["distractors"], about["distractors_without_room"]) == (placed, 20 - placed)
    (line,) = [text for text in words(about) if "afloat" in text]
    assert line.startswith(f"other things afloat: {placed}; no room for {20 - placed} more")


def test_things_afloat_change_nothing_else():
    plain, full = flown("orbit", 8.0, 2, distractors=0), flown("orbit", 8.0, 2)
    assert plain.props == ()
    assert "distractors_without_room" not in scenario(plain, "none")
    t = np.linspace(0.0, 20.0, 9)
    np.testing.assert_array_equal(plain.swarm.positions(t), full.swarm.positions(t))
    assert list(plain.sensors.fixes()) == list(full.sensors.fixes())
