# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulated flights as the messages that the estimator and the detector receive."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.adapters import telemetry_fields as fields
from aerial_gnss_ros.adapters.feed import Feed
from aerial_gnss_ros.adapters.results import detection_array
from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.bags.detect import ImageDetector
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion, quaternion_from_matrix
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar
from aerial_gnss_ros.detection.base import Detections, Image
from aerial_gnss_ros.simulation.experiment import Experiment, default_camera
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import START_NS, sensor_plan

Array = NDArray[np.float64]

DURATION_S, HEIGHT_M, ROBOTS = 40.0, 20.0, 3
FLIGHTS = ("orbit", "hover", "transit")
STAY = SwimPlan(0.0, 0.0)
"""How robots move over which a flight is called `still`."""
SIZE = 1280, 720
LATE_NS = 50_000_000
"""From an image's stamp to the detector's boxes where images themselves are simulated, ns."""

BLACK, PLAIN, NOISY = 0, 1, 2
"""What a picture shows: nothing, its boxes, or its boxes badly and others besides."""


@dataclass(frozen=True)
class Lens:
    """A CameraInfo: its stamp, and its fields as they are sent."""

    stamp_ns: int
    fields: dict[str, Any]


@dataclass(frozen=True)
class Picture:
    """An image, as far as the detector of these flights is concerned.

    Attributes:
        stamp_ns: of its header.
        index: which image of the flight it shows, counted from 1.
        shows: BLACK, PLAIN or NOISY.
        whole: whether all its bytes are there.
    """

    stamp_ns: int
    index: int
    shows: int = PLAIN
    whole: bool = True


Value = Fix | Orientation | Scalar | Lens | DetectionFrame | Picture


@dataclass(frozen=True)
class Item:
    """One message: when it comes (ns), on which input, and what it says."""

    arrival_ns: int
    source: str
    value: Value

    def says(self, value: Value) -> Item:
        """Return the same with another value."""
        return replace(self, value=value)


@dataclass(frozen=True)
class Flown:
    """A flight without any fault.

    Attributes:
        items: all messages in the order of arrival.
        times: (n,) of the images, s since the flight's start.
        seen: (n, robots) whether an image shows a robot.
        made: the simulation.
        boxes: of each image, as the detector finds them.
    """

    items: tuple[Item, ...]
    times: Array
    seen: NDArray[np.bool_]
    made: Experiment
    boxes: tuple[DetectionFrame, ...]

    def truth(self, t: float) -> Array:
        """Return the robots' true East, North (n, 2), m, at a time."""
        return np.asarray(self.made.swarm.positions(np.array([t]))[:, 0, :2])

    @property
    def local(self) -> LocalMap:
        """The flight's own chart, whatever origin the estimator chooses."""
        return LocalMap(self.made.flight.origin)


@lru_cache(maxsize=4)
def flown(kind: str, seed: int, aboard: str = "gimbal", sees: str = "detections") -> Flown:
    """Return a flight; equal arguments give the same one.

    Args:
        kind: orbit, hover or transit; "still orbit" and so on: over robots that stay.
        seed: of all chance.
        aboard: what orients the camera: `gimbal` relative to earth (attitude is not used), or
            `body`: the gimbal reports its angles in the body, and attitude is needed.
        sees: `detections` as they are, or `images` through the detector's own decoding.
    """
    family = kind.removeprefix("still ")
    plan = FlightPlan(kind=family, duration_s=DURATION_S, height_m=HEIGHT_M)
    swim = SwimPlan() if family == kind else STAY
    camera = default_camera(*SIZE)
    made = Experiment(
        GeneratedFlight(plan, seed), camera, sensor_plan(), robots=ROBOTS, swim=swim, seed=seed
    )
    images = list(made.detections())
    items = list(_telemetry(made, aboard))
    for index, (frame, _, found) in enumerate(images, start=1):
        lens = Lens(frame.stamp_ns, fields.camera_info_fields(camera, frame.stamp_ns, "camera"))
        items.append(Item(frame.log_ns, "camera_info", lens))
        shown: Value = found if sees == "detections" else Picture(frame.stamp_ns, index)
        items.append(Item(frame.log_ns, sees, shown))
    items.sort(key=lambda item: item.arrival_ns)
    return Flown(
        tuple(items),
        np.array([frame.t for frame, _, _ in images]),
        np.array([[name in boxes.names for name in made.swarm.names] for _, boxes, _ in images]),
        made,
        tuple(found for _, _, found in images),
    )


def _telemetry(made: Experiment, aboard: str) -> Iterator[Item]:
    sensors, plan = made.sensors, made.sensors_plan
    attitudes, gimbals = list(sensors.attitudes()), list(sensors.gimbals())
    if aboard == "body":  # both sample at the same times
        gimbals = [_in_body(*both) for both in zip(gimbals, attitudes, strict=True)]
    for source, values, late_s in (
        ("fix", sensors.fixes(), plan.fix_latency_s),
        ("attitude", attitudes, plan.attitude_latency_s),
        ("gimbal", gimbals, plan.gimbal_latency_s),
        ("height", sensors.heights(), plan.height_latency_s),
    ):
        for value in values:
            yield Item(value.stamp_ns + round(late_s * 1e9), source, value)


def _in_body(gimbal: Orientation, attitude: Orientation) -> Orientation:
    body = matrix_from_quaternion(attitude.quaternion)
    camera = matrix_from_quaternion(gimbal.quaternion)
    return replace(gimbal, quaternion=quaternion_from_matrix(body.T @ camera))


class Run:
    """One flight through the feed and the estimator, as live nodes and replay drive them.

    Attributes:
        results: each with the time at which it was published, s since the flight's start.
        died: the exception that ended it, empty where none did.
    """

    def __init__(
        self,
        flight: Flown,
        stated: dict[str, object] | None = None,
        engine: Estimator | None = None,
    ) -> None:
        config = estimator_config(stated or {})
        self.engine = engine or Estimator(config)
        self._given = flight, stated
        self.results: list[tuple[float, FrameResult]] = []
        self.died = ""
        feed = Feed(config, self.engine)
        self._handles = {one.name: one.handle for one in feed.subscriptions}
        self._images = ImageDetector(_Reader(flight.boxes), "camera/image_raw", "camera_info")

    def again(self) -> Run:
        """Return a copy that goes on by itself; not of a flight with images."""
        other = Run(*self._given, copy.deepcopy(self.engine))
        other.results = list(self.results)
        return other

    def fly(self, items: list[Item], *, ends: bool = True) -> Run:
        """Hand over all messages; an exception ends it, as it would end the program."""
        now = 0
        try:
            for item in items:
                now = item.arrival_ns
                self._handle(item)
                self._keep(now, self.engine.advance(now))
            if ends:
                self._keep(now, self.engine.flush())
        except Exception as error:  # noqa: BLE001 - whatever it is, it is what is looked for
            self.died = f"{type(error).__name__}: {error} at {_seconds(now):.2f} s"
        return self

    def _handle(self, item: Item) -> None:
        message = message_of(item.value)
        if item.source == "images":
            found = self._images.detect(message)
            if found is not None:
                self._handles["detections"](_object(found), item.arrival_ns + LATE_NS)
        elif item.source in self._handles:
            self._handles[item.source](message, item.arrival_ns)

    def _keep(self, now_ns: int, results: list[FrameResult]) -> None:
        self.results += [(_seconds(now_ns), result) for result in results]


class _Reader:
    """A detector that reads from a picture's first bytes which image it is."""

    name, class_names = "simulated", ("aqua",)

    def __init__(self, boxes: tuple[DetectionFrame, ...]) -> None:
        self._boxes = boxes

    def detect(self, image: Image) -> Detections:
        index = int(image[0, 0, 0]) + 256 * int(image[0, 1, 0])
        if not index:
            return _detections(np.zeros((0, 4)), np.zeros(0))
        found = self._boxes[index - 1]
        xywh, scores = np.hstack([found.centers, found.sizes]), found.scores
        if int(image[0, 2, 0]) == NOISY:
            rng = np.random.default_rng(index)
            xywh = xywh + np.array([20.0, 20.0, 0.0, 0.0]) * rng.standard_normal(xywh.shape)
            false = rng.uniform([0, 0, 20, 20], [*SIZE, 60, 60], (10, 4))
            xywh, scores = np.vstack([xywh, false]), np.append(scores, rng.uniform(0.3, 0.7, 10))
        return _detections(xywh, scores)


def _detections(xywh: Array, scores: Array) -> Detections:
    return Detections(xywh, scores, np.zeros(len(scores), np.int64), _Reader.class_names)


def message_of(value: Value) -> Any:
    """Return what the adapters read, by attribute as of any ROS message."""
    if isinstance(value, Fix):
        return _object(fields.fix_fields(value))
    if isinstance(value, Orientation):
        both = fields.imu_fields(value) | fields.quaternion_fields(value, "enu")
        return _object(both | {"orientation_covariance": [0.0] * 9})
    if isinstance(value, Scalar):
        return SimpleNamespace(data=value.value)
    if isinstance(value, Lens):
        header = header_fields(value.stamp_ns, "camera")
        return _object(_PLAIN_LENS | value.fields | {"header": header})
    if isinstance(value, Picture):
        return _image(value)
    names = tuple(sorted(set(value.class_ids)))
    boxes = SimpleNamespace(
        xywh=np.hstack([value.centers, value.sizes]), scores=value.scores, names=value.class_ids,
        class_names=names,
    )  # fmt: skip
    return _object(detection_array(boxes, header_fields(value.stamp_ns, value.frame_id)))


_PLAIN_LENS = {
    "binning_x": 0, "binning_y": 0,
    "roi": {"x_offset": 0, "y_offset": 0, "width": 0, "height": 0},
}  # fmt: skip


def _image(picture: Picture) -> Any:
    width, height = SIZE
    data = bytearray(width * height)
    if picture.shows != BLACK:
        data[:3] = picture.index % 256, picture.index // 256, picture.shows
    return SimpleNamespace(
        header=_object(header_fields(picture.stamp_ns, "camera")), encoding="mono8",
        width=width, height=height, step=width, data=bytes(data if picture.whole else data[:1000]),
    )  # fmt: skip


def _object(values: Any) -> Any:
    """Return nested dicts as objects with attributes."""
    if isinstance(values, dict):
        return SimpleNamespace(**{name: _object(value) for name, value in values.items()})
    if isinstance(values, list) and values and isinstance(values[0], dict):
        return [_object(value) for value in values]
    return values


def _seconds(stamp_ns: int) -> float:
    return (stamp_ns - START_NS) * 1e-9


def lens_of(camera: CameraModel, factor: float) -> dict[str, Any]:
    """Return the fields of a CameraInfo whose focal lengths are so many times too long."""
    K = camera.K * np.array([[factor, 1.0, 1.0], [1.0, factor, 1.0], [1.0, 1.0, 1.0]])
    return fields.camera_info_fields(replace(camera, K=K), 0, "camera")
