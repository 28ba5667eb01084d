# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A simulated flight as messages, tick by tick, and the truth that positions are judged by."""

from __future__ import annotations

import copy
import functools
import math
from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters.feed import Feed
from aerial_gnss_ros.adapters.results import detection_array
from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.adapters.telemetry_fields import CAMERA_INFO_TYPE, camera_info_fields
from aerial_gnss_ros.bags.typestore import make
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.geometry.frames import rpy_from_matrix
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.georeferencing.localization import locate
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum
from aerial_gnss_ros.core.values.samples import Array
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.simulation.experiment import Experiment, default_camera
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.sensors import START_NS, sensor_plan
from fuzz.types import typestore
from fuzz.vehicles import VEHICLES, Moment, messages

DETECTIONS_TYPE = "vision_msgs/msg/Detection2DArray"
FLOAT_TYPE = "std_msgs/msg/Float64"
TICKS_PER_S = 10
WARM_S = 6.0
"""Before a case robots are tracked for so long, s."""
DURATION_S = 40.0
SEED = 11
"""Its receiver is 1.4 m off, 1.2 sigma: as every second one is."""


@dataclass(frozen=True)
class Arrival:
    """A message as it comes.

    Attributes:
        log_ns: when.
        name: of the input.
        msgtype: of the message.
        raw: CDR.
        message: the same, read; never changed.
    """

    log_ns: int
    name: str
    msgtype: str
    raw: bytes
    message: Any


@functools.cache
def experiment(kind: str = "orbit") -> Experiment:
    """Return the flight: an orbit (or hover) at 20 m round (or beside) three robots that swim."""
    plan = FlightPlan(kind=kind, duration_s=DURATION_S, height_m=20.0)
    sensors = replace(sensor_plan("consumer"), attitude_hz=20.0, gimbal_hz=20.0)
    return Experiment(
        GeneratedFlight(plan, SEED), default_camera(1280, 720), sensors, robots=3, seed=SEED
    )


@functools.cache
def config_of(vehicle: str) -> EstimatorConfig:
    """Return a vehicle's parameters; a camera on a mast is told where it is."""
    chosen = VEHICLES[vehicle]
    if chosen.profile != "fixed_camera":
        return chosen.config()
    made = experiment(chosen.flight)
    pose = made.true_pose(made.frames()[0])
    rpy = np.degrees(rpy_from_matrix(pose.enu_from_camera))
    return chosen.config({
        "fix.latitude_deg": math.degrees(pose.latitude),
        "fix.longitude_deg": math.degrees(pose.longitude),
        "fix.altitude_m": pose.altitude,
        "gimbal.rpy_deg": rpy.tolist(),
        "height.value_m": pose.height,
    })  # fmt: skip


@functools.cache
def truth(kind: str = "orbit") -> Truth:
    """Return where the robots are."""
    made = experiment(kind)
    times = np.arange(-1.0, DURATION_S + 1.0, 0.1)
    return Truth(LocalMap(made.flight.origin), times, made.swarm.positions(times)[..., :2])


@dataclass(frozen=True)
class Truth:
    """Where the robots are.

    Attributes:
        local: frame of the positions.
        times: (n,) s since the start.
        paths: (robots, n, 2) East, North, m.
    """

    local: LocalMap
    times: Array
    paths: Array

    def at(self, stamp_ns: int) -> Array:
        """Return (robots, 2) positions; before the flight and after it those of its ends."""
        t = min(max((stamp_ns - START_NS) * 1e-9, -1.0), DURATION_S + 1.0)
        index = min(int(np.searchsorted(self.times, t)), len(self.times) - 1)
        return np.asarray(self.paths[:, index])

    @property
    def datum(self) -> MapDatum:
        """The origin."""
        return self.local.datum


class Phantoms:
    """Where damaged boxes lie: a box that stays for some images is a robot as far as anyone knows.

    Args:
        vehicle: name of the vehicle that sees them.
    """

    LASTING = 3
    """So many boxes at one place make a robot."""

    def __init__(self, vehicle: str) -> None:
        self._config = config_of(vehicle)
        self._made = experiment(VEHICLES[vehicle].flight)
        self._local = truth(VEHICLES[vehicle].flight).local
        self._frames = self._made.frames()
        self._seen = np.zeros((0, 2))

    def add(self, tick: int, message: Any, true: Any) -> None:
        """Keep where the boxes of a damaged image lie that are not in the true one."""
        centers = _centers(message)
        known = _centers(true)
        if not len(centers):
            return
        apart = np.linalg.norm(centers[:, None] - known[None], axis=2)
        new = centers[np.isfinite(centers).all(axis=1) & (apart > 1.0).all(axis=1)]
        pose = self._made.true_pose(self._frames[tick])
        points = locate(pose, self._made.camera, new, self._config.noise, self._config)
        places = self._local.positions(points.latitude, points.longitude)
        self._seen = np.concatenate([self._seen, places[np.isfinite(places).all(axis=1)]])

    @property
    def places(self) -> Array:
        """Where enough of them lie together, (n, 2) East, North, m."""
        seen = self._seen
        together = np.linalg.norm(seen[:, None] - seen[None], axis=2) < 5.0
        return np.asarray(seen[together.sum(axis=1) >= self.LASTING])


def _centers(message: Any) -> Array:
    places = [one.bbox.center.position for one in message.detections]
    return np.array([(place.x, place.y) for place in places], dtype=np.float64).reshape(-1, 2)


@functools.cache
def flown(vehicle: str) -> list[list[Arrival]]:
    """Return what a vehicle sends: for each image what comes after the image before it."""
    config, made = config_of(vehicle), experiment(VEHICLES[vehicle].flight)
    arrivals = [*_telemetry(config, made), *_images(VEHICLES[vehicle].flight)]
    arrivals.sort(key=lambda arrival: arrival.log_ns)
    frames = [arrival.log_ns for arrival in arrivals if arrival.name == "detections"]
    ticks: list[list[Arrival]] = [[] for _ in frames]
    for arrival in arrivals:
        tick = bisect_left(frames, arrival.log_ns)
        if tick < len(ticks):
            ticks[tick].append(arrival)
    return ticks


def _telemetry(config: EstimatorConfig, made: Experiment) -> list[Arrival]:
    sensors = made.sensors
    fixes, heights = list(sensors.fixes()), list(sensors.heights())
    found: list[Arrival] = []
    for fix, height in zip(fixes, heights, strict=True):
        found += _arrivals(config, Moment(fix=fix, height=height), fix.stamp_ns)
    for attitude, gimbal in zip(sensors.attitudes(), sensors.gimbals(), strict=True):
        found += _arrivals(config, Moment(attitude=attitude, gimbal=gimbal), attitude.stamp_ns)
    for log_ns in range(fixes[0].stamp_ns, fixes[-1].stamp_ns, 500_000_000):
        found.append(_arrival(log_ns, "water_level", FLOAT_TYPE, {"data": 0.0}))
        for name in config.depth.by_topic():
            found.append(
                _arrival(log_ns, f"depth_{name}" if name else "depth", FLOAT_TYPE, {"data": 0.0})
            )
    return found


def _arrivals(config: EstimatorConfig, moment: Moment, stamp_ns: int) -> list[Arrival]:
    return [
        _arrival(stamp_ns + 10_000_000, name, msgtype, fields)
        for name, (msgtype, fields) in messages(config, moment).items()
    ]


@functools.cache
def _images(kind: str) -> list[Arrival]:
    """Return cameras and boxes of a flight: the same for all vehicles that fly it."""
    made, found = experiment(kind), []
    for frame, _, boxes in made.detections():
        names = tuple(sorted(set(boxes.class_ids)))
        index = np.array([names.index(name) for name in boxes.class_ids], dtype=np.int64)
        xywh = np.hstack([boxes.centers, boxes.sizes])
        header = header_fields(frame.stamp_ns, "camera")
        array = detection_array(Detections(xywh, boxes.scores, index, names), header)
        info = camera_info_fields(made.camera, frame.stamp_ns, "camera")
        found.append(_arrival(frame.log_ns - 1, "camera_info", CAMERA_INFO_TYPE, info))
        found.append(_arrival(frame.log_ns, "detections", DETECTIONS_TYPE, array))
    return found


def _arrival(log_ns: int, name: str, msgtype: str, fields: dict[str, Any]) -> Arrival:
    message = make(msgtype, fields, typestore())
    raw = bytes(typestore().serialize_cdr(message, msgtype))
    return Arrival(log_ns, name, msgtype, raw, message)


class Aircraft:
    """An estimator in flight, fed as the node and replay feed it."""

    def __init__(self, vehicle: str, estimator: Estimator | None = None) -> None:
        config = config_of(vehicle)
        self.estimator = estimator or Estimator(config)
        feed = Feed(config, self.estimator)
        self.handlers: dict[str, Callable[[Any, int], None]] = {
            subscription.name: subscription.handle for subscription in feed.subscriptions
        }

    def feed(self, name: str, message: Any, log_ns: int) -> list[FrameResult]:
        """Hand over a message as it comes."""
        if name in self.handlers:
            self.handlers[name](message, log_ns)
        return self.estimator.advance(log_ns)


@functools.cache
def _warm(vehicle: str) -> Aircraft:
    aircraft = Aircraft(vehicle)
    results: list[FrameResult] = []
    for tick in flown(vehicle)[: round(WARM_S * TICKS_PER_S)]:
        for arrival in tick:
            results += aircraft.feed(arrival.name, arrival.message, arrival.log_ns)
    aircraft.estimator.take_events()
    if len(results[-1].estimates) < 3:
        raise RuntimeError(f"{vehicle} has {len(results[-1].estimates)} robots, not three")
    return aircraft


def in_flight(vehicle: str) -> Aircraft:
    """Return an aircraft of one's own that has tracked three robots for `WARM_S`."""
    # The feed's handlers are closures, which a copy would share: only the estimator is copied.
    return Aircraft(vehicle, copy.deepcopy(_warm(vehicle).estimator))
