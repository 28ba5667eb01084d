# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The fleet node: sightings of several drones in, one latched position for every robot out."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

from rclpy.publisher import Publisher

from aerial_gnss_ros.adapters.fleet_messages import (
    PARAMETERS,
    REQUEST,
    Request,
    drone_parameters,
    request_text,
)
from aerial_gnss_ros.adapters.fleet_overview import (
    DRONES,
    drone_values,
    drones_text,
    fleet_overview_text,
)
from aerial_gnss_ros.adapters.overview import OVERVIEW
from aerial_gnss_ros.adapters.sighting_messages import SIGHTINGS, sent_sighting
from aerial_gnss_ros.core.config.fleet import FleetConfig, fleet_config
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.fleet.shore import Link, Shore
from aerial_gnss_ros.core.values.errors import ConfigError, InputError
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.diagnostics import OK, STALE, WARN, Status
from aerial_gnss_ros.nodes.inputs import ONCE
from aerial_gnss_ros.nodes.on_demand import LOOK_S, OnDemandTopic
from aerial_gnss_ros.nodes.overdue import Overdue
from aerial_gnss_ros.nodes.positions import PositionTopics
from aerial_gnss_ros.nodes.ros_messages import message
from aerial_gnss_ros.nodes.schemas import FLEET
from aerial_gnss_ros.nodes.supervised import Given, SupervisedNode
from aerial_gnss_ros.text.sentences import counted

ADVANCE_S = 0.1
"""Longest time that a sighting waits for those of other drones: sorted, they need no going back."""
REQUEST_S = 1.0
DELAYED_S = 3.0
"""Delay from which a drone's line of diagnostics warns."""


class FleetNode(SupervisedNode):
    """Joins the sightings of several drones and publishes what an estimator does.

    Args:
        given: parameter files and namespace.

    Raises:
        ConfigError: a parameter cannot be used, or no drones are given.
    """

    def __init__(self, given: Given | None = None) -> None:
        super().__init__(FLEET, given or Given())
        config = fleet_config(self.values)
        if not config.drones:
            raise ConfigError("drones is empty: give the drones' namespaces: [drone1, drone2].")
        self._shore = Shore(config.drones, config.gnss_share, _origin(config), self.steady_ns)
        self._positions = PositionTopics(
            self, config.map, config.updates, Noise().value("correlation_time_s")
        )
        self._drones = self.announce(*DRONES, qos.latched())
        overviews = self.announce(*OVERVIEW, qos.latched())
        self._overviews = OnDemandTopic(overviews, self._overview_message)
        self._requests: dict[str, Publisher] = {}
        self._stamp_ns = self._results = 0
        self._overdue = Overdue()
        for source in config.drones:
            self._hear(source)
        self.every(ADVANCE_S, self._advance)
        self.every(REQUEST_S, self._request)
        self.every(LOOK_S, self._overviews.look)
        for topic in (DRONES[0], OVERVIEW[0]):
            self.claim(topic)
        self.get_logger().info(f"joins {', '.join(config.drones)}")

    def _hear(self, source: str) -> None:
        """Subscribe to what a drone sends."""
        self.listen(
            f"{source}: parameters", f"{source}/{PARAMETERS[0]}", PARAMETERS[1], qos.latched(),
            partial(self._describe, source), expected=ONCE,
            hint="its estimator needs sightings.drone",
        )  # fmt: skip
        self.listen(
            f"{source}: sightings", f"{source}/{SIGHTINGS[0]}", SIGHTINGS[1], qos.sightings(),
            partial(self._take, source), hint="it has no image, or none with a camera pose",
        )  # fmt: skip
        self._requests[source] = self.announce(
            f"{source}/{REQUEST[0]}", REQUEST[1], qos.sent_once()
        )

    def _describe(self, source: str, msg: Any) -> None:
        """Take in a drone's parameters."""
        try:
            told = drone_parameters(msg.data)
            self._shore.describe(source, told.drone, told.config, told.datum)
        except InputError as error:
            self.warn_seldom(f"{source}: {error}")

    def _take(self, source: str, msg: Any) -> None:
        """Take in a sighting."""
        now_ns = self.now_ns()
        if now_ns == 0:
            return  # simulated time has not begun
        try:
            self._shore.admit(source)
            self._shore.add(source, sent_sighting(msg.data), now_ns)
        except InputError as error:
            self.warn_seldom(f"{source}: {error}")

    def _advance(self) -> None:
        if self._shore.follow_clock(self.now_ns()):
            self.get_logger().warning(
                "the clock has gone backward: the fleet begins anew, and robots get new names"
            )
        result = self._shore.advance()
        self.log_sentences(self._shore.notes)
        self._shore.notes.clear()
        self._tell_failures()
        if result is not None:
            self._results += 1
            self._stamp_ns = result.stamp_ns
            self._overdue.processed(result.stamp_ns, self._passing_ns())
        else:
            result = self._predicted()
        if result is not None:
            self._overviews.keep(self._positions.send(result))

    def _tell_failures(self) -> None:
        """Log and count what could not be applied: that is an error of this program."""
        failures = [] if self._shore.history is None else self._shore.history.failures
        for failure in failures:
            self.survive(failure)
        failures.clear()

    def _predicted(self) -> FrameResult | None:
        """Return predicted positions while all drones are silent, so that no message grows old."""
        stamp_ns = self._overdue.due(self._passing_ns())
        if stamp_ns is None or not self._positions.departures.present:
            return None
        return self._shore.predicted(stamp_ns)

    def _passing_ns(self) -> int:
        """Return a time for differences: simulated time, or else a clock that is never stepped."""
        return self.now_ns() if self.get_clock().ros_time_is_active else self.steady_ns()

    def _overview_message(self, result: FrameResult) -> Any:
        """Return a result with all drones as JSON text for the page, by this node's clock."""
        text = fleet_overview_text(result, self.now_ns(), self._shore.links.values())
        return message(OVERVIEW[1], {"data": text})

    def _request(self) -> None:
        """Ask for what was lost, and say how the drones are."""
        for source, link in self._shore.links.items():
            wanted = tuple(link.gaps.wanted(self.steady_ns(), delay_s=link.delay_s))
            if wanted and link.gaps.session is not None:
                text = request_text(Request(link.drone, link.gaps.session, wanted))
                self._requests[source].publish(message(REQUEST[1], {"data": text}))
        if self._stamp_ns:
            text = drones_text(self._stamp_ns, self._shore.links.values())
            self._drones.publish(message(DRONES[1], {"data": text}))

    def statuses(self) -> list[Status]:
        """Return a line for each drone, and one for the positions."""
        lines = [_drone_status(link) for link in self._shore.links.values()]
        history = self._shore.history
        if history is None:
            return [*lines, Status("positions", STALE, "no drone has told its parameters yet")]
        robots = len(self._positions.departures.present)
        values = {
            "results": self._results,
            "sightings_applied": history.applied,
            "sightings_waiting": history.waiting,
            "gone_back": history.returned,
            **{f"refused_{reason}": count for reason, count in sorted(history.refused.items())},
        }
        words = counted(robots, "robot") if self._results else "no image yet"
        silent_s = self._overdue.seconds(self._passing_ns())
        if silent_s:
            words = f"no image of any drone for {silent_s:.0f} s: {words} predicted"
        level = WARN if silent_s else OK if self._results else STALE
        return [*lines, Status("positions", level, words, values)]


def _drone_status(link: Link) -> Status:
    """Return the line of a drone."""
    values = drone_values(link)
    level, words = OK, "agrees"
    if link.update is None:
        level, words = STALE, "no image yet"
    elif values["fault"]:
        level = WARN
        words = (
            f"its {values['fault']} is wrong by far more than it states; the filter allows for it"
        )
    elif values["disagrees"]:
        level = WARN
        words = "contradicts the others: a compass, gimbal, receiver or clock may be wrong"
    elif not values["shared_robots"]:
        words = "has no robot in common with another drone"
    if link.update is not None and link.update.report.clock.said:
        level, words = WARN, f"{words}; {link.update.report.clock.words}"
    if link.delay_s > DELAYED_S:
        level, words = WARN, f"{words}; {link.delay_s:.1f} s late"
    return Status(f"drone {link.drone}", level, words, values)


def _origin(config: FleetConfig) -> MapDatum | None:
    """Return the origin of `map` that the parameters give."""
    given = config.map
    if math.isnan(given.latitude_deg) or math.isnan(given.longitude_deg):
        return None
    return MapDatum(
        math.radians(given.latitude_deg), math.radians(given.longitude_deg), given.altitude_m
    )
