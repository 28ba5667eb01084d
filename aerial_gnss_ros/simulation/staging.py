# SPDX-License-Identifier: Apache-2.0
"""Draws random views with robots and other things in them, for training and testing detectors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera import CameraModel
from aerial_gnss_ros.core.errors import ConfigError
from aerial_gnss_ros.core.frames import matrix_from_rpy
from aerial_gnss_ros.simulation.hexapod import LENGTH, LIVERIES, RobotState
from aerial_gnss_ros.simulation.mesh import Mesh
from aerial_gnss_ros.simulation.props import random_prop
from aerial_gnss_ros.simulation.view import ViewPose, Window

FOCAL_PX = (550.0, 4500.0)
_APART_M = 0.75  # robots from one another
_SHALLOW_M, _SHALLOW = 0.06, 0.6  # most robots swim at the surface
_TRIES = 10_000
_LEAST_FLAT = np.radians(20.0)  # a camera straight down sees this far to the side
_MOST = 12  # robots beyond the first, and other things


@dataclass(frozen=True)
class Variety:
    """From which ranges views and what is in them are drawn.

    Attributes:
        height_m: of the camera above the water.
        tilt_deg: of the camera's axis off the vertical; the sight line to the first robot is no
            flatter than the larger one.
        long_px: of the first robot in the image.
        usual_long_px: the same, of most (`usual`) images.
        usual: share of the images whose robots are of usual size.
        depth_m: of robots below the surface (negative: floating high); 0.6 of them within 6 cm
            of it, as far as the range allows.
        extra_robots: how many more there are beside the first, on average.
        distractors: how many other things there are, on average.
    """

    height_m: tuple[float, float] = (5.0, 60.0)
    tilt_deg: tuple[float, float] = (0.0, 80.0)
    long_px: tuple[float, float] = (12.0, 250.0)
    usual_long_px: tuple[float, float] = (16.0, 120.0)
    usual: float = 0.75
    depth_m: tuple[float, float] = (-0.06, 1.2)
    extra_robots: float = 1.6
    distractors: float = 1.0


@dataclass(frozen=True)
class View:
    """One random view of the water, in whose middle distance a robot has a drawn size.

    Attributes:
        camera: the whole camera.
        pose: of the camera, in local ENU.
        window: the pixels that are rendered.
        pixel: (2,) where the first robot is to appear, inside the window.
        height: of the camera above the water, m.
        tilt: of the camera's axis off the vertical, rad.
    """

    camera: CameraModel
    pose: ViewPose
    window: Window
    pixel: NDArray[np.float64]
    height: float
    tilt: float


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
        # Empty windows anywhere, the horizon and the sky included.
        room = (camera.width - size[0] + 1, camera.height - size[1] + 1)
        corner = rng.integers((0, 0), room)
        window = Window(int(corner[0]), int(corner[1]), *size)
    props = _random_props(rng, camera, pose, window, robots, variety.distractors)
    return Stage(camera, pose, window, robots, props, view.height, view.tilt)


def random_view(
    rng: np.random.Generator,
    size: tuple[int, int] | None,
    image: tuple[int, int] | None = None,
    random_camera: Callable[[np.random.Generator, int, int], CameraModel] | None = None,
    variety: Variety | None = None,
) -> View:
    """Draws a view with water in its window.

    Args:
        rng: All randomness.
        size: Width and height of the window to render, None for the camera's whole image.
        image: Width and height of the camera, None to draw one.
        random_camera: Draws a camera of a width and height; None: the one of this module.
        variety: Ranges; None: the usual ones.

    Raises:
        ConfigError: no robot of these sizes can be seen from these heights with any lens.
    """
    variety = variety or Variety()
    least_tilt, most_tilt = np.radians(variety.tilt_deg)
    random_camera = random_camera or _random_camera
    width, height = image or ((1280, 720), (1920, 1080), (1440, 1080))[int(rng.integers(3))]
    long_px = _random_size(rng, variety)
    for _ in range(_TRIES):
        camera = random_camera(rng, width, height)
        tilt = float(least_tilt + (most_tilt - least_tilt) * rng.uniform() ** 0.8)
        rotation = matrix_from_rpy(
            np.radians(rng.normal(0.0, 3.0)), np.pi / 2 - tilt, rng.uniform(-np.pi, np.pi)
        )
        pose = ViewPose(np.array([0.0, 0.0, 1.0]), np.asarray(rotation))
        pixel = rng.uniform((0.0, 0.0), (width - 1.0, height - 1.0))
        spot = water_point(camera, pose, pixel)
        if spot is None:
            continue
        slant = float(np.hypot(np.hypot(spot[0], spot[1]), 1.0))
        if slant > 1.0 / np.cos(max(most_tilt, _LEAST_FLAT)):
            continue
        metres = float(camera.K[0, 0]) * LENGTH / long_px / slant
        # The size was drawn first, so that rare views do not make small robots rare.
        if variety.height_m[0] <= metres <= variety.height_m[1]:
            break
    else:
        low, high = variety.height_m
        raise ConfigError(
            f"no lens shows a robot {long_px:.0f} px long from {low:g} to {high:g} m; widen the "
            "range of heights or of sizes."
        )
    pose = replace(pose, position=np.array([*rng.uniform(-500.0, 500.0, 2), metres]))
    if size is None:
        window = Window(0, 0, width, height)
    else:
        window = _window_round(rng, pixel, size, (width, height))
    return View(camera, pose, window, pixel, metres, tilt)


def _random_size(rng: np.random.Generator, variety: Variety) -> float:
    usual = rng.random() < variety.usual
    low, high = variety.usual_long_px if usual else variety.long_px
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _random_camera(rng: np.random.Generator, width: int, height: int) -> CameraModel:
    """Focal length, principal point and a mild distortion that stays monotonic."""
    focal = float(np.exp(rng.uniform(*np.log(FOCAL_PX)))) * width / 1280.0
    cx = (width - 1) / 2.0 + rng.normal(0.0, 0.01 * width)
    cy = (height - 1) / 2.0 + rng.normal(0.0, 0.01 * height)
    corner = (np.hypot(width, height) / 2.0 / focal) ** 2
    k1 = rng.uniform(-0.12, 0.08) / max(corner, 0.3)
    k2 = -0.15 * k1 / max(corner, 0.3)
    p1, p2 = rng.normal(0.0, 0.0005, 2)
    k = [focal, 0.0, cx, 0.0, focal * rng.uniform(0.995, 1.005), cy, 0.0, 0.0, 1.0]
    p = [k[0], 0.0, cx, 0.0, 0.0, k[4], cy, 0.0, 0.0, 0.0, 1.0, 0.0]
    return CameraModel.from_camera_info(
        width, height, "plumb_bob", [k1, k2, p1, p2, 0.0], k, np.eye(3).ravel(), p, rectified=False
    )


def water_point(
    camera: CameraModel, pose: ViewPose, pixel: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """(2,) ENU point of the water under a pixel, None at and above the horizon."""
    rays, valid = camera.rays(np.asarray(pixel, dtype=np.float64).reshape(1, 2))
    ray = pose.enu_from_optical @ rays[0]
    if not valid[0] or ray[2] > -0.05:
        return None
    point: NDArray[np.float64] = pose.position[:2] - ray[:2] * pose.position[2] / ray[2]
    return point


def _window_round(
    rng: np.random.Generator,
    pixel: NDArray[np.float64],
    size: tuple[int, int],
    image: tuple[int, int],
) -> Window:
    """A window that has the pixel somewhere inside, not close to its edge."""
    offset = rng.uniform(0.12, 0.88, 2) * size
    corner = np.clip(np.round(pixel - offset), 0, np.subtract(image, size)).astype(int)
    return Window(int(corner[0]), int(corner[1]), *size)


def _random_robots(
    rng: np.random.Generator,
    camera: CameraModel,
    pose: ViewPose,
    window: Window,
    main: NDArray[np.float64] | None,
    variety: Variety,
) -> list[RobotState]:
    places = [] if main is None else [main]
    for _ in range(_some(rng, variety.extra_robots)):
        low = np.array([window.x, window.y], dtype=np.float64)
        high = low + np.array([window.width, window.height])
        place = water_point(camera, pose, rng.uniform(low, high))
        if place is None:
            continue
        if all(np.hypot(*(place - other)) > _APART_M for other in places):
            places.append(place)
    livery = sorted(LIVERIES)
    robots = []
    for i, place in enumerate(places):
        robots.append(
            RobotState(
                robot_id=f"aqua_{i + 1:02d}",
                east=float(place[0]),
                north=float(place[1]),
                course=float(rng.uniform(-np.pi, np.pi)),
                depth=_random_depth(rng, variety.depth_m),
                speed=float(rng.choice([0.0, rng.uniform(0.1, 1.0)], p=[0.25, 0.75])),
                phase=float(rng.uniform(0.0, 2 * np.pi)),
                roll=float(rng.normal(0.0, 0.08)),
                pitch=float(rng.normal(0.0, 0.08)),
                livery=livery[int(rng.integers(len(livery)))],
            )
        )
    return robots


def _some(rng: np.random.Generator, mean: float) -> int:
    """A number of things: often none, now and then many (geometric, cut)."""
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
) -> list[Mesh]:
    props = []
    for _ in range(_some(rng, mean)):
        low = np.array([window.x, window.y], dtype=np.float64)
        high = low + np.array([window.width, window.height])
        place = water_point(camera, pose, rng.uniform(low, high))
        if place is None:
            continue
        prop = random_prop(rng, float(place[0]), float(place[1]))
        reach = float(np.hypot(*(prop.vertices[:, :2] - place).T).max())
        if all(np.hypot(r.east - place[0], r.north - place[1]) > reach + 0.35 for r in robots):
            props.append(prop)
    return props
