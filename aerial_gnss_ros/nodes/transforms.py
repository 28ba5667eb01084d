# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Publishes /tf and /tf_static, as plain messages: no tf2 library is needed."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from aerial_gnss_ros.adapters.map_frame import Frames
from aerial_gnss_ros.adapters.results import OutgoingMessage
from aerial_gnss_ros.adapters.transforms import (
    TF,
    TF_STATIC,
    TF_TYPE,
    course_transforms,
    earth_transform,
)
from aerial_gnss_ros.core.config.processing import MapConfig
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.ros_messages import message

Announce = Callable[[str, str, QoSProfile], Publisher]


class Transforms:
    """Frames of one estimator.

    Args:
        config: selects the published transforms.
        frames: names.
        announce: returns a publisher of a topic.

    Raises:
        RosError: transforms are wanted, and tf2_msgs is not installed.
    """

    def __init__(self, config: MapConfig, frames: Frames, announce: Announce) -> None:
        self._frames = frames
        self._courses = announce(TF, TF_TYPE, qos.transforms()) if config.publish_tf else None
        self._earth = (
            announce(TF_STATIC, TF_TYPE, qos.latched()) if config.publish_earth_tf else None
        )
        self._datum: MapDatum | None = None

    def send(self, result: FrameResult) -> None:
        """Publish the frames of a result; /tf only while it has a subscriber."""
        datum = result.datum
        if self._earth is not None and datum is not None and not _same(datum, self._datum):
            self._datum = datum
            _publish(self._earth, earth_transform(result.stamp_ns, datum, self._frames))
        if self._courses is None or not self._courses.get_subscription_count():
            return
        found = course_transforms(result, self._frames)
        if found is not None:
            _publish(self._courses, found)


def _same(one: MapDatum, other: MapDatum | None) -> bool:
    return repr(one) == repr(other)  # NaN equals NaN here


def _publish(publisher: Publisher, outgoing: OutgoingMessage) -> None:
    publisher.publish(message(outgoing.msgtype, outgoing.fields))
