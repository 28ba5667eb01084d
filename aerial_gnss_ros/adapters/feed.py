# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Routes messages into the estimator, both live and in replay."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

from aerial_gnss_ros.adapters import canonical
from aerial_gnss_ros.adapters.kinds import ATTITUDE, FIX, GIMBAL, HEIGHT, Kind, stamp_ns
from aerial_gnss_ros.adapters.tf_gimbal import TfGimbal
from aerial_gnss_ros.adapters.transforms import TF, TF_STATIC, TF_TYPE
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.config.telemetry import (
    HEADERLESS,
    AttitudeConfig,
    FixConfig,
    GimbalConfig,
    HeightConfig,
)
from aerial_gnss_ros.core.telemetry.depths import depth_input
from aerial_gnss_ros.core.telemetry.reference_places import reference_input
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.errors import AerialGnssError, CameraError
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

TELEMETRY_DEPTH = 50  # half a second at 100 Hz while the estimator is busy
DETECTIONS_DEPTH = 10
TF_DEPTH = 200  # many small messages, one for each publisher


class Inputs(Protocol):
    """Inputs of `core.estimation.estimator.Estimator` that the feed uses."""

    def add_fix(self, fix: Fix) -> None:
        """Add a position of the drone."""

    def add_attitude(self, attitude: Orientation) -> None:
        """Add an orientation of the body."""

    def add_gimbal(self, gimbal: Orientation) -> None:
        """Add an orientation of the camera."""

    def add_height(self, height: Scalar) -> None:
        """Add a height of the drone."""

    def add_water_level(self, level: Scalar) -> None:
        """Add a water level."""

    def add_depth(self, class_id: str, depth: Scalar) -> None:
        """Add a depth that robots of a class send; an empty name stands for all."""

    def add_reference(self, name: str, fix: Fix) -> None:
        """Take a position that a reference sends."""

    def add_camera(self, stamp_ns: int, camera: CameraModel | None) -> None:
        """Add the camera model; None if it was unusable."""

    def add_detections(self, frame: DetectionFrame) -> None:
        """Add one image's boxes."""

    def refuse(self, name: str, trouble: str) -> None:
        """Record an unreadable message, and why."""


@dataclass(frozen=True)
class Subscription:
    """One topic that the estimator subscribes to.

    Attributes:
        name: the input: fix, attitude, gimbal, tf_static, height, home, water_level, depth,
            depth_<class>, reference_<name>, camera_info or detections.
        topic: relative to the namespace, or absolute.
        msgtype: such as `sensor_msgs/msg/NavSatFix`.
        depth: of the queue.
        handle: called with a message and its arrival time, ns.
        required: whether positions need it.
        versioned: whether the topic may end with `_v1`, `_v2`, … instead.
        sent_once: whether it may be sent once and latched, before there is a subscriber.
    """

    name: str
    topic: str
    msgtype: str
    depth: int
    handle: Callable[[Any, int], None]
    required: bool = True
    versioned: bool = False
    sent_once: bool = False


class Feed:
    """Subscriptions of the estimator for one configuration.

    Args:
        config: the estimator's parameters.
        estimator: receives the values.
        warn: called with a sentence about an unusable message (a CameraInfo of zeros), once per
            sentence.

    Attributes:
        subscriptions: the topics to subscribe to, without those replaced by a constant.
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
        self._home_altitude = math.nan
        gimbal = config.gimbal
        wanted = gimbal.source == "tf" and gimbal.reference != "fixed"
        self._tf = TfGimbal(gimbal) if wanted else None
        self.subscriptions = tuple(map(self._refusing, self._subscriptions()))

    def reconfigure(self, config: EstimatorConfig) -> None:
        """Subscribe to the references of another configuration; all else must be the same."""
        self._config = config
        self.subscriptions = tuple(map(self._refusing, self._subscriptions()))

    @property
    def stamps_on_arrival(self) -> list[str]:
        """Names of inputs whose messages are stamped on arrival."""
        config = self._config
        groups: dict[str, FixConfig | AttitudeConfig | GimbalConfig | HeightConfig] = {
            "fix": config.fix,
            "attitude": config.attitude,
            "gimbal": config.gimbal,
            "height": config.height,
        }
        heard = {one.name for one in self.subscriptions}
        return [name for name, one in groups.items() if name in heard and _on_arrival(one)]

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
                _sent_once(
                    "camera_info", config.camera.topic, "sensor_msgs/msg/CameraInfo", self._info
                )
            )
        if fix.source == "topic":
            found.append(_of_kind("fix", fix.topic, FIX[fix.type], self._fix))
        if attitude.source == "topic":
            kind = ATTITUDE[attitude.type]
            needed = config.needs_attitude
            found.append(_of_kind("attitude", attitude.topic, kind, self._attitude, needed))
        if gimbal.source == "topic" and gimbal.reference != "fixed":
            found.append(_of_kind("gimbal", gimbal.topic, GIMBAL[gimbal.type], self._gimbal))
        if self._tf is not None:
            found.append(Subscription("gimbal", TF, TF_TYPE, TF_DEPTH, self._transforms))
            static = Subscription("tf_static", TF_STATIC, TF_TYPE, TF_DEPTH, self._static)
            found.append(replace(static, required=False, sent_once=True))
        if height.source == "topic":
            found.append(_of_kind("height", height.topic, HEIGHT[height.type], self._height))
            if height.home_topic:
                home = _of_kind("home", height.home_topic, HEIGHT[height.type], self._home)
                found.append(replace(home, sent_once=True))
        found.append(_number("water_level", config.water_level.topic, self._water_level))
        for class_id, topic in config.depth.by_topic().items():
            found.append(_number(depth_input(class_id), topic, self._depth_of(class_id)))
        for one in config.references:
            if one.topic:
                name, receive = reference_input(one.name), self._reference(one.name)
                found.append(_of_kind(name, one.topic, FIX["navsatfix"], receive, required=False))
        return found

    def _refusing(self, subscription: Subscription) -> Subscription:
        """Return a subscription that refuses messages that cannot be read."""
        name, read = subscription.name, subscription.handle

        def handle(msg: Any, arrival_ns: int) -> None:
            try:
                read(msg, arrival_ns)
            except (MemoryError, AerialGnssError):  # ConfigError is meant for the user
                raise
            except Exception as error:  # noqa: BLE001 - no message ends a flight
                why = f"it cannot be read ({type(error).__name__}: {error})"
                self._estimator.refuse(name, why)

        return replace(subscription, handle=handle)

    def _detections(self, msg: Any, _arrival_ns: int) -> None:
        self._estimator.add_detections(canonical.detection_frame(msg))

    def _fix(self, msg: Any, arrival_ns: int) -> None:
        config = self._config.fix
        stamp = stamp_ns(msg, arrival_ns, config.stamp)
        self._estimator.add_fix(FIX[config.type].read(msg, stamp, config))
        if not self._config.needs_attitude:
            self._fixed_camera(stamp)

    def _attitude(self, msg: Any, arrival_ns: int) -> None:
        config = self._config.attitude
        stamp = stamp_ns(msg, arrival_ns, config.stamp)
        self._estimator.add_attitude(ATTITUDE[config.type].read(msg, stamp, config))
        if self._config.needs_attitude:
            self._fixed_camera(stamp)

    def _gimbal(self, msg: Any, arrival_ns: int) -> None:
        config = self._config.gimbal
        stamp = stamp_ns(msg, arrival_ns, config.stamp)
        self._estimator.add_gimbal(GIMBAL[config.type].read(msg, stamp, config))

    def _transforms(self, msg: Any, arrival_ns: int, static: bool = False) -> None:
        tf = self._tf
        assert tf is not None  # noqa: S101 - there is no subscription without
        for one in tf.add(msg, arrival_ns, static):
            self._estimator.add_gimbal(one)
        trouble = tf.trouble(arrival_ns)
        if trouble:
            self._estimator.refuse("gimbal", trouble)

    def _static(self, msg: Any, arrival_ns: int) -> None:
        self._transforms(msg, arrival_ns, static=True)

    def _fixed_camera(self, stamp: int) -> None:
        """Add the orientation of a camera that TF has as fixed to its base."""
        fixed = None if self._tf is None else self._tf.static(stamp)
        if fixed is not None:
            self._estimator.add_gimbal(fixed)

    def _height(self, msg: Any, arrival_ns: int) -> None:
        config = self._config.height
        stamp = stamp_ns(msg, arrival_ns, config.stamp)
        height = HEIGHT[config.type].read(msg, stamp, config)
        if config.home_topic:
            if math.isnan(self._home_altitude):  # an altitude is not a height: use none
                return
            height = replace(height, value=height.value - self._home_altitude)
        self._estimator.add_height(height)

    def _home(self, msg: Any, arrival_ns: int) -> None:
        """Store the altitude of the take-off point, which is sent rarely or once."""
        config = self._config.height
        altitude = HEIGHT[config.type].read(msg, arrival_ns, config).value
        if math.isfinite(altitude):
            self._home_altitude = altitude

    def _water_level(self, msg: Any, arrival_ns: int) -> None:
        self._estimator.add_water_level(canonical.scalar(msg, arrival_ns))

    def _depth_of(self, class_id: str) -> Callable[[Any, int], None]:
        def receive(msg: Any, arrival_ns: int) -> None:
            self._estimator.add_depth(class_id, canonical.scalar(msg, arrival_ns))

        return receive

    def _reference(self, name: str) -> Callable[[Any, int], None]:
        def receive(msg: Any, arrival_ns: int) -> None:
            stamp = stamp_ns(msg, arrival_ns, "header")
            self._estimator.add_reference(name, canonical.fix(msg, stamp))

        return receive

    def _info(self, msg: Any, arrival_ns: int) -> None:
        key = canonical.camera_key(msg)
        if (
            key != self._camera_key
        ):  # building a model costs more than comparing, and CameraInfo comes with every image
            self._camera_key = key
            self._camera = self._model(msg)
        stamp = stamp_ns(msg, arrival_ns, self._config.camera.stamp)
        self._estimator.add_camera(stamp, self._camera)

    def _model(self, msg: Any) -> CameraModel | None:
        try:
            return canonical.camera(msg, self._config.camera.rectified)
        except CameraError as error:
            sentence = f"{self._config.camera.topic}: {error}"
        except (ArithmeticError, LookupError, TypeError, ValueError) as error:
            sentence = (
                f"{self._config.camera.topic}: this CameraInfo is unusable "
                f"({type(error).__name__}: {error})."
            )
        if self._warn is not None and sentence != self._last_warning:
            self._last_warning = sentence
            self._warn(sentence)
        return None


def _on_arrival(config: FixConfig | AttitudeConfig | GimbalConfig | HeightConfig) -> bool:
    return config.stamp == "arrival" or config.type in HEADERLESS


def _sent_once(
    name: str, topic: str, msgtype: str, handle: Callable[[Any, int], None]
) -> Subscription:
    return Subscription(name, topic, msgtype, TELEMETRY_DEPTH, handle, sent_once=True)


def _number(name: str, topic: str, handle: Callable[[Any, int], None]) -> Subscription:
    kind = "std_msgs/msg/Float64"
    return Subscription(name, topic, kind, TELEMETRY_DEPTH, handle, required=False, sent_once=True)


def _of_kind(
    name: str,
    topic: str,
    kind: Kind[Any, Any],
    handle: Callable[[Any, int], None],
    required: bool = True,
) -> Subscription:
    depth = TELEMETRY_DEPTH
    return Subscription(name, topic, kind.msgtype, depth, handle, required, kind.versioned)
