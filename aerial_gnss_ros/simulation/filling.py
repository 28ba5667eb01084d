# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fills random views with robots and other objects, for training and testing detectors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.simulation.flotsam import KINDS, random_colour
from aerial_gnss_ros.simulation.hexapod import LENGTH, LIVERIES, Paint, RobotState
from aerial_gnss_ros.simulation.mesh import Mesh
from aerial_gnss_ros.simulation.props import PROPS, Kinds, random_prop
from aerial_gnss_ros.simulation.robot_models import robot_model
from aerial_gnss_ros.simulation.staging import Variety, random_view, water_point
from aerial_gnss_ros.simulation.view import ViewPose, Window

_APART_M = 0.75  # robots of 0.65 m from one another
_CLEAR_M = 0.35  # their middle from other things
_SHALLOW_M, _SHALLOW = 0.06, 0.6  # most robots swim at the surface
_MOST = 12  # robots beyond the first, and other things


@dataclass(frozen=True)
class Stage:
    """One random view and what is in it."""

    camera: CameraModel
    pose: ViewPose
    window: Window
    robots: list[RobotState]
    props: list[Mesh]
    height: float
    tilt: float


def random_stage(
    rng: np.random.Generator,
    size: tuple[int, int] | None,
    occupied: float,
    image: tuple[int, int] | None = None,
    variety: Variety | None = None,
) -> Stage:
    """Draws a view.

    Args:
        rng: All randomness.
        size: Width and height of the window to render, None for the camera's whole image.
        occupied: Probability that there are robots.
        image: Width and height of the camera, None to draw one.
        variety: Ranges; None: the usual ones.
    """
    variety = variety or Variety()
    view = random_view(rng, size, image, variety=variety)
    camera, pose, window = view.camera, view.pose, view.window
    robots: list[RobotState] = []
    if rng.random() < occupied:
        main = water_point(camera, pose, view.pixel)
        robots = _random_robots(rng, camera, pose, window, main, variety)
    elif size is not None and rng.random() < 0.5:
        # Empty windows may be anywhere, including horizon and sky.
        room = (camera.width - size[0] + 1, camera.height - size[1] + 1)
        corner = rng.integers((0, 0), room)
        window = Window(int(corner[0]), int(corner[1]), *size)
    props = _random_props(rng, camera, pose, window, robots, variety.distractors, PROPS)
    if variety.flotsam:  # drawn first, so that older seeds keep their results
        props += _random_props(rng, camera, pose, window, robots, variety.flotsam, KINDS)
    return Stage(camera, pose, window, robots, props, view.height, view.tilt)


def _random_robots(
    rng: np.random.Generator,
    camera: CameraModel,
    pose: ViewPose,
    window: Window,
    main: NDArray[np.float64] | None,
    variety: Variety,
) -> list[RobotState]:
    places = [] if main is None else [main]
    apart = _APART_M * _longer(variety.robot_model)
    for _ in range(_some(rng, variety.extra_robots)):
        low = np.array([window.x, window.y], dtype=np.float64)
        high = low + np.array([window.width, window.height])
        place = water_point(camera, pose, rng.uniform(low, high))
        if place is None:
            continue
        if all(np.hypot(*(place - other)) > apart for other in places):
            places.append(place)
    livery, called = sorted(LIVERIES), robot_model(variety.robot_model).name
    robots = []
    for i, place in enumerate(places):
        robots.append(
            RobotState(
                robot_id=f"{called}_{i + 1:02d}",
                east=float(place[0]),
                north=float(place[1]),
                course=float(rng.uniform(-np.pi, np.pi)),
                depth=_random_depth(rng, variety.depth_m),
                speed=float(rng.choice([0.0, rng.uniform(0.1, 1.0)], p=[0.25, 0.75])),
                phase=float(rng.uniform(0.0, 2 * np.pi)),
                roll=float(rng.normal(0.0, 0.08)),
                pitch=float(rng.normal(0.0, 0.08)),
                livery=livery[int(rng.integers(len(livery)))],
                paint=_random_paint(rng) if rng.random() < variety.painted else None,
                class_name=called,
                model=variety.robot_model,
            )
        )
    return robots


def _random_paint(rng: np.random.Generator) -> Paint:
    """Three colours."""
    one, two, three = (random_colour(rng).tolist() for _ in range(3))
    return tuple(one), tuple(two), tuple(three)


def _some(rng: np.random.Generator, mean: float) -> int:
    """A random number of objects: often 0, sometimes many (geometric, clipped)."""
    return min(_MOST, int(rng.geometric(1.0 / (1.0 + mean))) - 1)


def _random_depth(rng: np.random.Generator, depth_m: tuple[float, float]) -> float:
    low, high = depth_m
    border = float(np.clip(_SHALLOW_M, low, high))
    shallow = rng.random() < _SHALLOW
    return float(rng.uniform(low, border) if shallow else rng.uniform(border, high))


def _random_props(
    rng: np.random.Generator,
    camera: CameraModel,
    pose: ViewPose,
    window: Window,
    robots: list[RobotState],
    mean: float,
    kinds: Kinds,
) -> list[Mesh]:
    props = []
    for _ in range(_some(rng, mean)):
        low = np.array([window.x, window.y], dtype=np.float64)
        high = low + np.array([window.width, window.height])
        place = water_point(camera, pose, rng.uniform(low, high))
        if place is None:
            continue
        prop = random_prop(rng, float(place[0]), float(place[1]), kinds)
        reach = float(np.hypot(*(prop.vertices[:, :2] - place).T).max())
        if all(
            np.hypot(r.east - place[0], r.north - place[1]) > reach + _CLEAR_M * _longer(r.model)
            for r in robots
        ):
            props.append(prop)
    return props


def _longer(model: str) -> float:
    """How many times as long as the hexapod a robot is, at least 1."""
    return max(1.0, robot_model(model).length / LENGTH)
