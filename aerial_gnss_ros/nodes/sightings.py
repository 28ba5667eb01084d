# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Publishes what a drone tells the fleet, and sends again what was lost."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from aerial_gnss_ros.adapters.fleet_messages import PARAMETERS, REQUEST, parameters_text, request
from aerial_gnss_ros.adapters.sighting_messages import SIGHTINGS, sighting_text
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.fleet.outbox import Outbox
from aerial_gnss_ros.core.fleet.sighting import SightingTap
from aerial_gnss_ros.core.tracker.protocol import Tracking
from aerial_gnss_ros.core.tracker.tracker import Tracker
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.estimates import MapDatum
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.ros_messages import message, message_class
from aerial_gnss_ros.nodes.supervised import SupervisedNode

RESEND_S = 0.1
AGAIN = 10
"""Sightings sent again each `RESEND_S`, so that the newest are not delayed: 60 s in 6 s."""


class SightingTopics:
    """The topic `sightings` of one estimator, and those around it.

    Images are numbered and kept for 64 s whether or not anybody subscribes, so that an outage that
    ends a subscription loses nothing.

    Args:
        node: the estimator node.
        drone: name of the drone.
        estimator: sees the images.
        values: its parameters, by dotted name.
    """

    def __init__(
        self, node: SupervisedNode, drone: str, estimator: Estimator, values: Mapping[str, Any]
    ) -> None:
        self._node, self._drone = node, drone
        self._outbox = Outbox(drone)
        self._again: dict[tuple[int, int], None] = {}  # session and number, in order
        self._values, self._told = values, ""
        self._datum: MapDatum | None = None
        self._tap: SightingTap | None = None
        estimator.wrap_tracking(self._tapped)
        self._sent = node.announce(*SIGHTINGS, qos.sightings())
        self._parameters = node.announce(*PARAMETERS, qos.latched())
        node.create_subscription(
            message_class(REQUEST[1]), REQUEST[0], self._take_request, qos.sent_once()
        )
        node.every(RESEND_S, self._send_again)
        self.use(values)

    def use(self, values: Mapping[str, Any]) -> None:
        """Tell the parameters that are used from now on."""
        self._values = values
        self._tell()

    def send(self, datum: MapDatum | None) -> None:
        """Publish the images processed since the last call.

        Args:
            datum: origin of the drone's frame `map`, if known.
        """
        if datum is not None:
            self._datum = datum
            self._tell()
        for seen in self._tap.drain() if self._tap is not None else ():
            sent = self._outbox.add(seen)
            if self._sent.get_subscription_count():
                self._publish(self._sent, SIGHTINGS[1], sighting_text(sent))

    def _tapped(self, tracker: Tracking) -> SightingTap:
        assert isinstance(tracker, Tracker)  # noqa: S101 - the default one
        if self._tap is None:
            self._tap = SightingTap(tracker)
        self._tap.follow(tracker)
        return self._tap

    def _tell(self) -> None:
        """Publish the parameters if they have changed."""
        text = parameters_text(self._drone, self._values, self._datum)
        if text != self._told:
            self._told = text
            self._publish(self._parameters, PARAMETERS[1], text)

    def _take_request(self, msg: Any) -> None:
        try:
            wanted = request(msg.data)
        except InputError as error:
            self._node.warn_seldom(str(error))
            return
        if wanted.drone != self._drone:
            return
        for first, last in wanted.ranges:
            for one in self._outbox.between(wanted.session, first, last):
                self._again[one.session, one.sequence] = None

    def _send_again(self) -> None:
        for session, number in list(self._again)[:AGAIN]:
            del self._again[session, number]
            for one in self._outbox.between(session, number, number):
                self._publish(self._sent, SIGHTINGS[1], sighting_text(one))

    @staticmethod
    def _publish(publisher: Any, kind: str, text: str) -> None:
        publisher.publish(message(kind, {"data": text}))
