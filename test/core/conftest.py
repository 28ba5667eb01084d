# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A small world for tests of the estimator: a drone, robots, and telemetry that may be wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import pymap3d
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, quaternion_from_matrix
from aerial_gnss_ros.core.geometry.geodesy import LocalMap, geodetic_from_enu
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import MapDatum
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

SECOND = 1_000_000_000
START_NS = 1_700_000_000 * SECOND
LATITUDE, LONGITUDE = math.radians(13.194), math.radians(-59.6415)
CAMERA = CameraModel.from_camera_info(
    1280, 720, "plumb_bob", [], [900.0, 0, 640.0, 0, 900.0, 360.0, 0, 0, 1.0]
)
ORIGIN = {"map.latitude_deg": math.degrees(LATITUDE), "map.longitude_deg": math.degrees(LONGITUDE)}

MIDDLE = [640.0, 360.0]

Place = Callable[[float], tuple[float, ...]]


def project_to_image(pose, camera, latitude, longitude):
    """Return pixels (n, 2) of places on the water, and which are in the image (n,).

    The way back from what `locate` returns, by another library.
    """
    water = 0.0 if math.isnan(pose.altitude) else pose.altitude - pose.height
    place = pose.latitude, pose.longitude, water + pose.height
    offsets = pymap3d.geodetic2enu(latitude, longitude, water, *place, deg=False)
    forward, left, up = pose.enu_from_camera.T @ np.stack([np.atleast_1d(one) for one in offsets])
    return camera.project(np.stack([-left, -up, forward], axis=1))


def stamp(seconds: float) -> int:
    return START_NS + round(seconds * SECOND)


# Many drones of the tests hover: the same place and attitude again and again.
@lru_cache(maxsize=4096)
def geodetic(east: float, north: float, up: float) -> tuple[float, ...]:
    """Return latitude and longitude in rad and altitude in m of a place on the map."""
    return tuple(map(float, geodetic_from_enu(east, north, up, LATITUDE, LONGITUDE, 0.0)))


@lru_cache(maxsize=4096)
def attitude(roll: float, pitch: float, yaw: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the rotation of angles in deg as matrix (3, 3) and quaternion (4,), read-only."""
    matrix = matrix_from_rpy(*np.radians((roll, pitch, yaw)))
    quaternion = quaternion_from_matrix(matrix)
    matrix.flags.writeable = quaternion.flags.writeable = False
    return matrix, quaternion


@dataclass
class World:
    """Truth, and what the sensors make of it. East, North, Up from the map's origin."""

    drone: Place = lambda _t: (0.0, 0.0, 30.0)
    rpy_deg: Place = lambda _t: (0.0, 60.0, 90.0)  # looks north, 60 deg down
    robots: dict[str, Place] = field(default_factory=dict)
    gnss_bias: tuple[float, float] = (0.0, 0.0)
    rpy_bias_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    pixel_sigma: float = 0.0
    missed: float = 0.0
    hidden: Callable[[str, float], bool] = lambda _name, _t: False
    clutter: float = 0.0
    seed: int = 1
    camera: CameraModel = CAMERA
    local: LocalMap = field(default_factory=lambda: LocalMap(MapDatum(LATITUDE, LONGITUDE, 0.0)))

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)

    def pose(self, t: float) -> CameraPose:
        east, north, up = self.drone(t)
        latitude, longitude, _ = geodetic(east, north, up)
        return CameraPose(stamp(t), latitude, longitude, up, up, attitude(*self.rpy_deg(t))[0])

    def fix(self, t: float) -> Fix:
        east, north, up = self.drone(t)
        return Fix(stamp(t), *geodetic(east + self.gnss_bias[0], north + self.gnss_bias[1], up))

    def gimbal(self, t: float) -> Orientation:
        angles = np.add(self.rpy_deg(t), self.rpy_bias_deg)
        return Orientation(stamp(t), attitude(*map(float, angles))[1])

    def height(self, t: float) -> Scalar:
        return Scalar(stamp(t), float(self.drone(t)[2]))

    def frame(self, t: float, class_id: str = "aqua") -> DetectionFrame:
        """Boxes of the robots in view at t, shuffled, with misses and clutter."""
        centers = []
        if self.robots:
            at = self.local.places(np.array([place(t) for place in self.robots.values()]))
            pixels, inside = project_to_image(self.pose(t), self.camera, *at)
        for i, name in enumerate(self.robots):
            if self.hidden(name, t) or self.rng.random() < self.missed:
                continue
            if inside[i]:
                centers.append(pixels[i] + self.pixel_sigma * self.rng.standard_normal(2))
        false = self.rng.poisson(self.clutter)
        centers += list(self.rng.uniform((0, 0), (1280, 720), (false, 2)))
        self.rng.shuffle(centers)
        return boxes(t, centers, class_id)


def boxes(t: float, centers: object, class_id: str = "aqua", score: float = 0.9) -> DetectionFrame:
    array = np.array(centers, dtype=np.float64).reshape(-1, 2)
    count = len(array)
    sizes = np.full((count, 2), 8.0)
    return DetectionFrame(
        stamp(t), "camera", array, sizes, np.full(count, score), (class_id,) * count
    )


def estimator(values: dict[str, object] | None = None) -> Estimator:
    return Estimator(estimator_config({**ORIGIN, **(values or {})}))


def play(
    engine, world, duration, *, begin=0.0, images=5, telemetry=20, until_flush=True, camera=CAMERA
):
    """Fly a world through an estimator as messages would come; return the results."""
    results = []
    ticks = sorted(
        [(begin + i / telemetry, 0) for i in range(round(duration * telemetry) + 1)]
        + [(begin + i / images, 1) for i in range(round(duration * images) + 1)]
    )
    engine.add_camera(stamp(begin), camera)
    for t, kind in ticks:
        if kind:
            engine.add_detections(world.frame(t))
        else:
            engine.add_fix(world.fix(t))
            engine.add_gimbal(world.gimbal(t))
            engine.add_height(world.height(t))
        results += engine.advance(stamp(t))
    return results + (engine.flush() if until_flush else [])


class Scene:
    """One image at t = 1 s with everything it needs, from which a test takes something away."""

    def __init__(self, values=None):
        self.engine = estimator(values)
        self.world = World()
        self.boxes = boxes(1.0, [MIDDLE])
        self.camera = (0.0, CAMERA)
        self.samples = dict.fromkeys(("fix", "attitude", "gimbal", "height"), (0.9, 1.1))
        self.change = {}

    def _value(self, name, t):
        if name in self.change:
            return self.change[name](stamp(t))
        if name == "attitude":
            return Orientation(stamp(t), np.array([0.0, 0.0, 0.0, 1.0]))
        return getattr(self.world, name)(t)

    def feed(self):
        if self.camera is not None:
            self.engine.add_camera(stamp(self.camera[0]), self.camera[1])
        for name, times in self.samples.items():
            for t in times:
                getattr(self.engine, f"add_{name}")(self._value(name, t))
        self.engine.add_detections(self.boxes)

    def run(self):
        self.feed()
        results = self.engine.advance(stamp(1.2))
        results += self.engine.advance(stamp(30.0))
        assert [result.stamp_ns for result in results] == [self.boxes.stamp_ns]
        return results[0]


class Tools:
    """The above, for tests."""

    Scene = Scene
    World = World
    boxes = staticmethod(boxes)
    camera = CAMERA
    middle = MIDDLE
    estimator = staticmethod(estimator)
    origin = ORIGIN
    play = staticmethod(play)
    project_to_image = staticmethod(project_to_image)
    stamp = staticmethod(stamp)


@pytest.fixture(scope="session")
def sea() -> type[Tools]:
    return Tools
