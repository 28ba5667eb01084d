# SPDX-License-Identifier: Apache-2.0
"""Routes messages into the estimator; live nodes and replay both go through exactly this."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from aerial_gnss_ros.adapters import canonical
from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.core.camera import CameraModel
from aerial_gnss_ros.core.config import EstimatorConfig
from aerial_gnss_ros.core.errors import CameraError
from aerial_gnss_ros.core.values import DetectionFrame, Fix, Orientation, Scalar

TELEMETRY_DEPTH = 50  # half a second at 100 Hz while the estimator is busy
DETECTIONS_DEPTH = 10

_ORIENTATION_TYPES = {
    "imu": "sensor_msgs/msg/Imu",
    "quaternion": "geometry_msgs/msg/QuaternionStamped",
    "vector3": "geometry_msgs/msg/Vector3Stamped",
}
_HEIGHT_TYPES = {
    "float64": "std_msgs/msg/Float64",
    "float32": "std_msgs/msg/Float32",
    "range": "sensor_msgs/msg/Range",
}


class Inputs(Protocol):
    """What the feed needs of `core.estimator.Estimator`."""

    def add_fix(self, fix: Fix) -> None:
        """Take a position of the drone."""

    def add_attitude(self, attitude: Orientation) -> None:
        """Take an orientation of the body."""

    def add_gimbal(self, gimbal: Orientation) -> None:
        """Take an orientation of the camera."""

    def add_height(self, height: Scalar) -> None:
        """Take a height of the drone."""

    def add_water_level(self, level: Scalar) -> None:
        """Take a level of the water."""

    def add_camera(self, stamp_ns: int, camera: CameraModel | None) -> None:
        """Take the camera's description; None when it could not be used."""

    def add_detections(self, frame: DetectionFrame) -> None:
        """Take one image's boxes."""


@dataclass(frozen=True)
class Subscription:
    """One topic that the estimator listens to.

    Attributes:
        name: the input: fix, attitude, gimbal, height, water_level, camera_info or detections.
        topic: relative to the namespace, or absolute.
        msgtype: such as `sensor_msgs/msg/NavSatFix`.
        depth: of the queue.
        handle: takes a message and when it came, ns.
        required: whether no position can be found without it.
    """

    name: str
    topic: str
    msgtype: str
    depth: int
    handle: Callable[[Any, int], None]
    required: bool = True


class Feed:
    """The estimator's inputs as the configuration wants them.

    Args:
        config: the estimator's parameters.
        estimator: takes the values.
        warn: takes a sentence when a message cannot be used at all (a CameraInfo of zeros); the
            same sentence is not repeated.

    Attributes:
        subscriptions: the topics to listen to; those replaced by a constant are absent.
    """

    def __init__(
        self,
        config: EstimatorConfig,
        estimator: Inputs,
        warn: Callable[[str], None] | None = None,
    ) -> None:
        self._config = config
        self._estimator = estimator
        self._warn = warn
        self._last_warning = ""
        self._camera_key: tuple[Any, ...] = ()
        self._camera: CameraModel | None = None
        self.subscriptions = tuple(self._subscriptions())

    def _subscriptions(self) -> list[Subscription]:
        config = self._config
        fix, attitude, gimbal, height = config.fix, config.attitude, config.gimbal, config.height
        found = [
            Subscription(
                "detections",
                config.detections.topic,
                "vision_msgs/msg/Detection2DArray",
                DETECTIONS_DEPTH,
                self._detections,
            )
        ]
        if config.camera.source == "topic":
            found.append(
                _telemetry(
                    "camera_info", config.camera.topic, "sensor_msgs/msg/CameraInfo", self._info
                )
            )
        if fix.source == "topic":
            found.append(_telemetry("fix", fix.topic, "sensor_msgs/msg/NavSatFix", self._fix))
        if attitude.source == "topic":
            msgtype = _ORIENTATION_TYPES[attitude.type]
            needed = config.needs_attitude
            found.append(
                _telemetry("attitude", attitude.topic, msgtype, self._attitude, required=needed)
            )
        if gimbal.source == "topic" and gimbal.reference != "fixed":
            msgtype = _ORIENTATION_TYPES[gimbal.type]
            found.append(_telemetry("gimbal", gimbal.topic, msgtype, self._gimbal))
        if height.source == "topic":
            msgtype = _HEIGHT_TYPES[height.type]
            found.append(_telemetry("height", height.topic, msgtype, self._height))
        level = _telemetry(
            "water_level",
            config.water_level.topic,
            "std_msgs/msg/Float64",
            self._water_level,
            required=False,
        )
        return [*found, level]

    def _detections(self, msg: Any, _arrival_ns: int) -> None:
        self._estimator.add_detections(canonical.detection_frame(msg))

    def _fix(self, msg: Any, arrival_ns: int) -> None:
        self._estimator.add_fix(
            canonical.fix(msg, _stamp_ns(msg, arrival_ns, self._config.fix.stamp))
        )

    def _attitude(self, msg: Any, arrival_ns: int) -> None:
        config = self._config.attitude
        stamp_ns = _stamp_ns(msg, arrival_ns, config.stamp)
        self._estimator.add_attitude(canonical.orientation(msg, stamp_ns, config.type))

    def _gimbal(self, msg: Any, arrival_ns: int) -> None:
        config = self._config.gimbal
        stamp_ns = _stamp_ns(msg, arrival_ns, config.stamp)
        self._estimator.add_gimbal(canonical.orientation(msg, stamp_ns, config.type))

    def _height(self, msg: Any, arrival_ns: int) -> None:
        stamp_ns = _stamp_ns(msg, arrival_ns, self._config.height.stamp)
        self._estimator.add_height(canonical.scalar(msg, stamp_ns))

    def _water_level(self, msg: Any, arrival_ns: int) -> None:
        self._estimator.add_water_level(canonical.scalar(msg, arrival_ns))

    def _info(self, msg: Any, _arrival_ns: int) -> None:
        key = canonical.camera_key(msg)
        if key != self._camera_key:  # a model costs more than a comparison, and comes per image
            self._camera_key = key
            self._camera = self._model(msg)
        self._estimator.add_camera(nanoseconds(msg.header.stamp), self._camera)

    def _model(self, msg: Any) -> CameraModel | None:
        try:
            return canonical.camera(msg, self._config.camera.rectified)
        except CameraError as error:
            sentence = f"{self._config.camera.topic}: {error}"
            if self._warn is not None and sentence != self._last_warning:
                self._last_warning = sentence
                self._warn(sentence)
            return None


def _telemetry(
    name: str,
    topic: str,
    msgtype: str,
    handle: Callable[[Any, int], None],
    *,
    required: bool = True,
) -> Subscription:
    return Subscription(name, topic, msgtype, TELEMETRY_DEPTH, handle, required)


def _stamp_ns(msg: Any, arrival_ns: int, clock: str) -> int:
    return nanoseconds(msg.header.stamp) if clock == "header" else arrival_ns
