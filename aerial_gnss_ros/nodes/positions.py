# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Publishes results: positions of each robot, latched, with markers, frames and samples."""

from __future__ import annotations

from typing import Any

from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from aerial_gnss_ros.adapters.departures import Departures
from aerial_gnss_ros.adapters.map_frame import OnWater, frames
from aerial_gnss_ros.adapters.results import (
    CURRENT,
    MAP_DATUM,
    MARKERS,
    OutgoingMessage,
    covariance_parts,
    markers,
    position_messages,
    position_update,
)
from aerial_gnss_ros.core.config.processing import MapConfig, UpdatesConfig
from aerial_gnss_ros.core.estimation.position_updates import PositionUpdates
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.on_demand import LOOK_S, OnDemandTopic
from aerial_gnss_ros.nodes.ros_messages import message
from aerial_gnss_ros.nodes.supervised import SupervisedNode
from aerial_gnss_ros.nodes.transforms import Transforms

MOST_LATCHED = 100  # robots that keep their topics; the one lost longest is dropped first


class PositionTopics:
    """All topics of results, but the overview.

    Args:
        node: publishes them.
        map_: the frame.
        updates: samples for other filters.
        correlation_time_s: of the platform's errors, s.

    Attributes:
        departures: robots that are present.
        publishers: of robots, by topic.
    """

    def __init__(
        self,
        node: SupervisedNode,
        map_: MapConfig,
        updates: UpdatesConfig,
        correlation_time_s: float,
    ) -> None:
        self._node = node
        self.departures = Departures()
        self.publishers: dict[str, Publisher] = {}
        self._latched: dict[str, list[str]] = {}  # topics by robot, the one lost longest first
        self._frames = frames(map_, node.get_namespace())
        self._on_water = OnWater(self._frames)
        self._markers = OnDemandTopic(node.announce(*MARKERS, qos.latched()), self._markers_message)
        self._updates = PositionUpdates(updates, correlation_time_s)
        self._transforms = Transforms(map_, self._frames, node.announce)
        node.every(LOOK_S, self._markers.look)
        node.claim(MAP_DATUM)
        node.claim(MARKERS[0])

    def send(self, result: FrameResult) -> FrameResult:
        """Publish a result; return it on the water, as it was published."""
        result = self._on_water.leveled(result)
        for outgoing in position_messages(self.departures.completed(result), self._frames):
            self._publisher(outgoing).publish(message(outgoing.msgtype, outgoing.fields))
        samples = [
            position_update(one, result.datum, self._frames) for one in self._updates.due(result)
        ]
        for estimate in result.estimates:
            samples += covariance_parts(estimate, result.datum, self._frames)
        for outgoing in samples:
            publisher = self._publisher(outgoing, qos.sent_once())
            publisher.publish(message(outgoing.msgtype, outgoing.fields))
        self._give_up_oldest()
        self._transforms.send(result)
        self._markers.show(result)
        return result

    def _markers_message(self, result: FrameResult) -> Any:
        """Return the markers of a result, the most expensive message."""
        outgoing = markers(result, self._frames)
        return message(outgoing.msgtype, outgoing.fields)

    def _give_up_oldest(self) -> None:
        """Remove the topics of robots lost long ago if there are very many: most are false."""
        present = {one.robot_id for one in self.departures.present}
        for name in present:  # robots in view are removed last
            self._latched[name] = self._latched.pop(name)
        while len(self._latched) > max(MOST_LATCHED, len(present)):
            oldest = next(name for name in self._latched if name not in present)
            for topic in self._latched.pop(oldest):
                self._node.destroy_publisher(self.publishers.pop(topic))

    def _publisher(self, outgoing: OutgoingMessage, profile: QoSProfile | None = None) -> Publisher:
        if outgoing.topic not in self.publishers:
            if outgoing.topic not in (CURRENT, MAP_DATUM):
                self._latched.setdefault(outgoing.topic.split("/")[1], []).append(outgoing.topic)
            self.publishers[outgoing.topic] = self._node.announce(
                outgoing.topic, outgoing.msgtype, profile or qos.latched()
            )
        return self.publishers[outgoing.topic]
