# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Draws random views of the water: lens, height, tilt, and the position of a robot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.robot_models import AQUA, robot_model
from aerial_gnss_ros.simulation.view import ViewPose, Window

FOCAL_PX = (550.0, 4500.0)
_TRIES = 3_000
_LEAST_FLAT = np.radians(20.0)  # a camera straight down sees this far to the side


@dataclass(frozen=True)
class Variety:
    """Ranges from which views and their contents are drawn.

    Attributes:
        height_m: of the camera above the water.
        tilt_deg: of the camera's axis off the vertical; the sight line to the first robot is no
            flatter than the larger one.
        long_px: of the first robot in the image.
        usual_long_px: the same, of most (`usual`) images.
        usual: share of the images whose robots are of usual size.
        depth_m: of robots below the surface (negative: floating high); 60 % of them within 6 cm of
            it, as far as the range allows.
        extra_robots: mean number of robots beside the first.
        painted: share of the robots with random colours instead of a livery.
        distractors: mean number of other objects.
        flotsam: mean number of further objects of random shape and colour.
        wind_mps: wind speed, which sets waves and foam; None: drawn by the renderer.
        robot_model: shape of the robots, a name for `robot_models.robot_model`.
    """

    height_m: tuple[float, float] = (5.0, 60.0)
    tilt_deg: tuple[float, float] = (0.0, 80.0)
    long_px: tuple[float, float] = (12.0, 250.0)
    usual_long_px: tuple[float, float] = (16.0, 120.0)
    usual: float = 0.75
    depth_m: tuple[float, float] = (-0.06, 1.2)
    extra_robots: float = 1.6
    painted: float = 0.3
    distractors: float = 1.0
    flotsam: float = 0.0
    wind_mps: tuple[float, float] | None = None
    robot_model: str = AQUA


@dataclass(frozen=True)
class View:
    """One random view of the water, in whose middle distance a robot has a drawn size.

    Attributes:
        camera: the whole camera.
        pose: of the camera, in local ENU.
        window: the pixels that are rendered.
        pixel: (2,) of the first robot, inside the window.
        height: of the camera above the water, m.
        tilt: of the camera's axis off the vertical, rad.
    """

    camera: CameraModel
    pose: ViewPose
    window: Window
    pixel: NDArray[np.float64]
    height: float
    tilt: float


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
    long_m = robot_model(variety.robot_model).length
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
        metres = float(camera.K[0, 0]) * long_m / long_px / slant
        # The size is drawn first, so that rare views do not make small robots rare.
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
