# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Draws the content of one image: view, light, sea, robots and other objects."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.simulation.blender.hexapod import Robot, random_build, random_flippers
from aerial_gnss_ros.simulation.blender.props import HARBOUR
from aerial_gnss_ros.simulation.blender.ranges import Ranges, Span
from aerial_gnss_ros.simulation.flotsam import KINDS
from aerial_gnss_ros.simulation.hexapod import LENGTH
from aerial_gnss_ros.simulation.mesh import Mesh
from aerial_gnss_ros.simulation.props import PROPS, Kinds
from aerial_gnss_ros.simulation.robot_models import AQUA, robot_model
from aerial_gnss_ros.simulation.scene import WATERS, Colour, Scene, random_scene, with_wind
from aerial_gnss_ros.simulation.staging import FOCAL_PX, Variety, View, random_view, water_point

Array = NDArray[np.float64]
APART_M = 0.8
DEEPEST_M = 1.0
SHALLOW_M, SHALLOW = 0.08, 0.6  # most robots swim at the surface
_MOST = 6  # robots beyond the first, and other things


@dataclass(frozen=True)
class Sea:
    """Parameters of waves and sky that `Scene` lacks.

    Attributes:
        spectrum: of the ocean modifier.
        choppiness: 0 (round crests) to 1.5 (sharp ones).
        aerosol, ozone: densities of the sky model, 1 is clear air.
        clouds: whether the sky has broken clouds.
        scatter: multiplies the light that the water sends back.
    """

    spectrum: str
    choppiness: float
    aerosol: float
    ozone: float
    clouds: bool
    scatter: float


@dataclass(frozen=True)
class Prop:
    """A distractor at a position on the surface."""

    mesh: Mesh
    east: float
    north: float


@dataclass(frozen=True)
class Shot:
    """Everything that determines one image."""

    view: View
    scene: Scene
    sea: Sea
    robots: tuple[Robot, ...]
    props: tuple[Prop, ...]


def random_shot(
    rng: np.random.Generator,
    ranges: Ranges,
    size: tuple[int, int] | None,
    occupied: float,
    image: tuple[int, int] | None = None,
    variety: Variety | None = None,
) -> Shot:
    """Draws the content of an image.

    Args:
        rng: all randomness.
        ranges: of light, sea, robots' looks and other things.
        size: width and height of the part of the image that is rendered, None for all of it.
        occupied: probability that there are robots.
        image: size of the camera's image, None to draw one.
        variety: ranges of the view, and how many robots and things; None: the usual ones.
    """
    variety = variety or Variety()
    view = random_view(rng, size, image, _pinhole, variety)
    # The position does not matter, and single precision favours small numbers.
    view = replace(view, pose=replace(view.pose, position=np.array([0.0, 0.0, view.height])))
    scene, sea = _random_light(rng, ranges)
    scene = with_wind(rng, scene, variety.wind_mps)
    robots = _random_robots(rng, ranges, view, variety) if rng.random() < occupied else ()
    longer = max(1.0, robot_model(variety.robot_model).length / LENGTH) if robots else 1.0
    kinds = PROPS if ranges.props == "floating" else HARBOUR
    props = _random_props(rng, kinds, view, robots, variety.distractors, longer)
    if variety.flotsam:
        props += _random_props(rng, KINDS, view, robots, variety.flotsam, longer)
    return Shot(view, scene, sea, robots, props)


def _pinhole(rng: np.random.Generator, width: int, height: int) -> CameraModel:
    """A lens without distortion, as Blender's camera is."""
    focal = float(np.exp(rng.uniform(*np.log(FOCAL_PX)))) * width / 1280.0
    return pinhole(focal, width, height)


def pinhole(focal: float, width: int, height: int) -> CameraModel:
    """The camera with this focal length in px and its axis in the image's middle."""
    k = [focal, 0.0, (width - 1) / 2, 0.0, focal, (height - 1) / 2, 0.0, 0.0, 1.0]
    p = [focal, 0.0, k[2], 0.0, 0.0, focal, k[5], 0.0, 0.0, 0.0, 1.0, 0.0]
    return CameraModel.from_camera_info(
        width, height, "plumb_bob", [0.0] * 5, k, np.eye(3).ravel(), p, rectified=False
    )


def _of(rng: np.random.Generator, spans: tuple[Span, ...]) -> float:
    """A value from one of the spans, each with a probability proportional to its length."""
    lengths = np.array([high - low for low, high in spans])
    low, high = spans[int(rng.choice(len(spans), p=lengths / lengths.sum()))]
    return float(rng.uniform(low, high))


def _random_light(rng: np.random.Generator, ranges: Ranges) -> tuple[Scene, Sea]:
    radiance, attenuation = WATERS[str(rng.choice(ranges.waters))]
    overcast = rng.random() < ranges.overcast
    turbid = float(rng.lognormal(0.0, 0.25))
    scene = replace(
        random_scene(rng),
        sun_elevation=float(np.radians(_of(rng, ranges.sun_elevation_deg))),
        sun_light=0.0 if overcast else float(rng.uniform(0.6, 1.0)),
        wind_speed=_of(rng, ranges.wind_mps),
        water_colour=_scaled(radiance, rng.uniform(0.85, 1.15, 3)),
        attenuation=_scaled(attenuation, np.full(3, turbid)),
    )
    sea = Sea(
        spectrum=str(rng.choice(ranges.spectra)),
        choppiness=float(rng.uniform(0.2, 1.3)),
        aerosol=float(rng.uniform(0.3, 3.0)),
        ozone=float(rng.uniform(0.5, 2.0)),
        clouds=bool(not overcast and rng.random() < ranges.clouds),
        scatter=float(rng.lognormal(-0.6, 0.3)),
    )
    return scene, sea


def _scaled(colour: Colour, gain: Array) -> Colour:
    blue, green, red = (float(c * g) for c, g in zip(colour, gain, strict=True))
    return blue, green, red


def _count(rng: np.random.Generator, mean: float) -> int:
    """A random number with this mean (before clipping), often 0, rarely large."""
    return min(int(rng.geometric(1.0 / (1.0 + mean))) - 1, _MOST)


def _random_depth(rng: np.random.Generator, variety: Variety) -> float:
    low, high = max(variety.depth_m[0], -0.05), min(variety.depth_m[1], DEEPEST_M)
    if rng.random() < SHALLOW:
        return float(np.clip(rng.uniform(-0.05, SHALLOW_M), low, high))
    return float(rng.uniform(min(max(low, SHALLOW_M), high), high))


def _random_robots(
    rng: np.random.Generator, ranges: Ranges, view: View, variety: Variety
) -> tuple[Robot, ...]:
    main = water_point(view.camera, view.pose, view.pixel)
    places = [] if main is None else [main]
    longer = max(1.0, robot_model(variety.robot_model).length / LENGTH)
    for _ in range(_count(rng, variety.extra_robots)):
        place = _in_window(rng, view)
        if place is not None and all(np.hypot(*(place - p)) > APART_M * longer for p in places):
            places.append(place)
    robots = []
    model = robot_model(variety.robot_model)
    for i, (east, north) in enumerate(places):
        build = random_build(rng, ranges)
        paint = build.paint.hull, build.paint.deck, build.paint.mark
        robots.append(
            Robot(
                robot_id=f"{model.name}_{i + 1:02d}",
                build=build,
                flippers=random_flippers(rng, ranges),
                east=float(east),
                north=float(north),
                depth=_random_depth(rng, variety),
                course=float(rng.uniform(-np.pi, np.pi)),
                roll=float(rng.normal(0.0, ranges.leans_rad)),
                pitch=float(rng.normal(0.0, ranges.leans_rad)),
                class_name=model.name,
                mesh=None if model.name == AQUA else model.build(0.0, paint),
            )
        )
    return tuple(robots)


def _in_window(rng: np.random.Generator, view: View) -> Array | None:
    window = view.window
    low = np.array([window.x, window.y], dtype=np.float64)
    high = low + np.array([window.width, window.height])
    return water_point(view.camera, view.pose, rng.uniform(low, high))


def _random_props(
    rng: np.random.Generator,
    kinds: Kinds,
    view: View,
    robots: tuple[Robot, ...],
    mean: float,
    longer: float,
) -> tuple[Prop, ...]:
    props = []
    clear = 0.4 * longer
    for _ in range(_count(rng, mean)):
        place = _in_window(rng, view)
        yaw = rng.uniform(-np.pi, np.pi)
        c, s = np.cos(yaw), np.sin(yaw)
        mesh = kinds[str(rng.choice(sorted(kinds)))](rng)
        mesh = mesh.placed(np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), (0.0, 0.0, 0.0))
        if place is None:
            continue
        reach = float(np.hypot(*mesh.vertices[:, :2].T).max())
        if all(np.hypot(r.east - place[0], r.north - place[1]) > reach + clear for r in robots):
            props.append(Prop(mesh, float(place[0]), float(place[1])))
    return tuple(props)
