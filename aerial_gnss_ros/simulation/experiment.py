# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A simulated flight as a whole: true motion, robots, sensors and the camera's clock.

All stamps are on one clock. With a latency L the image stamped t shows the scene at t - L, as
`camera.latency_s` says. Truth is stamped with its time of validity, so a result for the image
stamped t is to be compared with the truth at t - L.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.core.values.samples import Fix
from aerial_gnss_ros.simulation.afloat import ROBOT_M, place_things
from aerial_gnss_ros.simulation.boxes import Boxes, DetectorPlan, detected, projected_boxes
from aerial_gnss_ros.simulation.chance import generator
from aerial_gnss_ros.simulation.flight import Flight
from aerial_gnss_ros.simulation.hexapod import LENGTH, RobotState
from aerial_gnss_ros.simulation.mesh import Mesh
from aerial_gnss_ros.simulation.placement import place_robots, view_width
from aerial_gnss_ros.simulation.robot_models import robot_model
from aerial_gnss_ros.simulation.robots import STEP_S, Swarm, SwimPlan, fitted
from aerial_gnss_ros.simulation.sensors import (
    START_NS,
    SensorPlan,
    Sensors,
    Ticks,
    geodetic,
    sensor_plan,
    ticks,
)
from aerial_gnss_ros.simulation.view import ViewPose

Array = NDArray[np.float64]

CAMERA_FRAME = "camera"
LEAD_S = 1.0
"""Time of telemetry before and after the images, so that each is bracketed, s."""
FIELD_OF_VIEW = math.radians(73.7)
"""Horizontal field of view: 24 mm equivalent, as on most small camera drones."""
DISTORTION = (-0.045, 0.018, 4e-4, -3e-4, -0.004)


def default_camera(width: int, height: int, field_of_view: float = FIELD_OF_VIEW) -> CameraModel:
    """Return a camera with a little distortion and a principal point a little off the middle.

    Args:
        width: px.
        height: px.
        field_of_view: across the width, rad, before distortion.
    """
    focal = 0.5 * width / math.tan(0.5 * field_of_view)
    K = np.array(
        [
            [focal, 0.0, 0.5 * (width - 1) + 0.003 * width],
            [0.0, focal, 0.5 * (height - 1) - 0.002 * width],
            [0.0, 0.0, 1.0],
        ]
    )
    return CameraModel(width, height, "plumb_bob", K, np.array(DISTORTION))


@dataclass(frozen=True)
class CameraClock:
    """Times at which images are taken and arrive.

    Attributes:
        rate_hz: images a second.
        latency_s: an image stamped t shows the scene at t - latency_s.
        delay_s: from the later of stamp and scene to the image's arrival, s.
    """

    rate_hz: float = 10.0
    latency_s: float = 0.0
    delay_s: float = 0.08

    def __post_init__(self) -> None:
        if not 0.1 <= self.rate_hz <= 120.0:
            raise ConfigError(
                f"the image rate must lie within 0.1 to 120 Hz, not {self.rate_hz:g}."
            )
        if not abs(self.latency_s) <= 3.0:
            raise ConfigError(f"the latency must lie within -3 to 3 s, not {self.latency_s:g}.")


@dataclass(frozen=True)
class Frame:
    """Times of one image.

    Attributes:
        stamp_ns: of the image.
        log_ns: when the image arrives.
        t: time of the scene, s since the flight's start.
        pose: of the camera then, in the flight's chart.
    """

    stamp_ns: int
    log_ns: int
    t: float
    pose: ViewPose


@dataclass
class Experiment:
    """One simulated flight; equal arguments give equal values.

    Attributes:
        flight: true motion of drone and camera.
        camera: lens and image size.
        sensors_plan: rates, latencies, noise.
        clock: of the camera.
        robots: number of robots, where `places` is None.
        places: (n, 2) East, North start positions of the robots, m; None: where the camera sees
            water.
        swim: how they move.
        detector: errors of the simulated detector.
        distractors: number of other objects to float in view, for rendering; `props` are those with
            room clear of the robots.
        survey_m: one sigma of the error, each axis, with which the first robot's position is known,
            if it is a beacon; 0: of no robot.
        seed: of all random numbers.
        world_seed: of robots and of what is said about them; None: `seed`. One for several drones.
        others: flights of further drones, which are to see the robots, too.
    """

    flight: Flight
    camera: CameraModel
    sensors_plan: SensorPlan = field(default_factory=sensor_plan)
    clock: CameraClock = field(default_factory=CameraClock)
    robots: int = 3
    places: Array | None = None
    swim: SwimPlan = field(default_factory=SwimPlan)
    detector: DetectorPlan = field(default_factory=DetectorPlan)
    distractors: int = 0
    survey_m: float = 0.0
    seed: int = 1
    world_seed: int | None = None
    others: Sequence[Flight] = ()

    def __post_init__(self) -> None:
        world = self.seed if self.world_seed is None else self.world_seed
        margin = LEAD_S + abs(self.clock.latency_s)
        self._span = (-margin, self.flight.duration_s + margin)
        self.swim = fitted(self.swim, view_width(self.flight, self.camera))
        if self.places is None:
            rng = generator(world, "places")
            apart = self.swim.apart_m or 0.0
            self.places = place_robots(
                self.flight, self.camera, self.robots, rng, apart, self.others
            )
        self.swarm = Swarm(self.places, self.swim, world, *self._span)
        self.props = self._props()
        self.sensors = Sensors(self.flight, self.sensors_plan, self.seed, *self._span)

    def _props(self) -> tuple[Mesh, ...]:
        """Return the distractors, placed clear of the robots' paths."""
        rng = generator(self.seed, "distractors")
        swum = self.swarm.positions(np.arange(*self._span, STEP_S))[..., :2].reshape(-1, 2)
        longest = max(robot_model(name).length for name in self.swim.models)
        robot_m = ROBOT_M + 0.5 * max(0.0, longest - LENGTH)
        return place_things(self.flight, self.camera, self.distractors, swum, rng, robot_m)

    def frames(self) -> list[Frame]:
        """Return all images in the order of their stamps."""
        at = ticks(self.clock.rate_hz, 0.0, self.flight.duration_s)
        if len(at.t) > 1 and at.t[-1] > self.flight.duration_s - 0.5 / self.clock.rate_hz:
            at = Ticks(at.stamps_ns[:-1], at.t[:-1])  # a minute at 10 Hz is 600 images
        latency_ns = round(self.clock.latency_s * 1e9)
        delay_ns = round(self.clock.delay_s * 1e9)
        scenes = at.t - self.clock.latency_s
        motion = self.flight.sample(scenes)
        return [
            Frame(
                int(stamp),
                int(stamp) + max(0, -latency_ns) + delay_ns,
                float(scenes[i]),
                ViewPose(motion.camera[i], motion.enu_from_camera[i]),
            )
            for i, stamp in enumerate(at.stamps_ns)
        ]

    def states(self, frame: Frame) -> list[RobotState]:
        """Return the robots as an image shows them."""
        return self.swarm.states(frame.t)

    def projected(self, frame: Frame) -> Boxes:
        """Return true boxes without rendering; their centres are the projected bodies' middles."""
        t = np.array([frame.t])
        return projected_boxes(
            self.camera,
            frame.pose,
            self.swarm.names,
            self.swarm.class_names,
            self.swarm.positions(t)[:, 0],
            self.swarm.courses(t)[:, 0],
            self.swarm.models,
        )

    def detections(self) -> Iterator[tuple[Frame, Boxes, DetectionFrame]]:
        """Yield every image's true boxes and the simulated detector's boxes."""
        rng = generator(self.seed, "detector")
        for frame in self.frames():
            boxes = self.projected(frame)
            found = detected(
                boxes, self.detector, self.camera, self.swim.class_name or self.swim.models[0],
                frame.stamp_ns, CAMERA_FRAME, rng,
            )  # fmt: skip
            yield frame, boxes, found

    def reference(self) -> Fix | None:
        """Return where the first robot is said to be: its error is one draw; None: nobody says."""
        if not self.survey_m:
            return None
        place = self.swarm.positions([0.0])[0, 0].copy()
        world = self.seed if self.world_seed is None else self.world_seed
        place[:2] += self.survey_m * generator(world, "survey").standard_normal(2)
        latitude, longitude, altitude = geodetic(self.flight.origin, place[None])
        spread = self.survey_m**2 * np.eye(3)
        return Fix(START_NS, float(latitude[0]), float(longitude[0]), float(altitude[0]), spread)

    def robot_fixes(self) -> Iterator[tuple[str, list[Fix]]]:
        """Yield each robot's true positions, at the images' rate and a little longer."""
        at = ticks(self.clock.rate_hz, *self._span)
        positions = self.swarm.positions(at.t)
        for name, path in zip(self.swarm.names, positions, strict=True):
            latitude, longitude, altitude = geodetic(self.flight.origin, path)
            yield (
                name,
                [
                    Fix(int(stamp), float(latitude[i]), float(longitude[i]), float(altitude[i]))
                    for i, stamp in enumerate(at.stamps_ns)
                ],
            )

    def true_pose(self, frame: Frame) -> CameraPose:
        """Return the camera's true pose for the core's geometry."""
        position = frame.pose.position
        latitude, longitude, altitude = geodetic(self.flight.origin, position)
        return CameraPose(
            START_NS + round(frame.t * 1e9), float(latitude), float(longitude), float(position[2]),
            float(altitude), frame.pose.enu_from_camera,
        )  # fmt: skip
