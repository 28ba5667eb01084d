# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The estimator node: detections and telemetry in, one latched position for every robot out."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import Any

from aerial_gnss_ros.adapters.feed import Feed, Subscription
from aerial_gnss_ros.adapters.overview import OVERVIEW, input_lights, overview_text
from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.adapters.versions import newest_version
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.estimation.area_file import load_area
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.estimation.health import RobotSummary, summary
from aerial_gnss_ros.core.numerics import linear_assignment
from aerial_gnss_ros.core.telemetry.arrivals import UNFILLED_NS
from aerial_gnss_ros.core.telemetry.input_status import InputState
from aerial_gnss_ros.core.telemetry.reference_places import is_reference
from aerial_gnss_ros.core.values.estimates import FrameResult, State
from aerial_gnss_ros.core.values.samples import Scalar
from aerial_gnss_ros.detection.background import begun
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.arrivals import SECOND_NS
from aerial_gnss_ros.nodes.diagnostics import ERROR, OK, STALE, WARN, Status
from aerial_gnss_ros.nodes.inputs import ALWAYS, ONCE, OPTIONAL, Input
from aerial_gnss_ros.nodes.on_demand import LOOK_S, OnDemandTopic
from aerial_gnss_ros.nodes.overdue import Overdue
from aerial_gnss_ros.nodes.positions import PositionTopics
from aerial_gnss_ros.nodes.ros_messages import message
from aerial_gnss_ros.nodes.schemas import ESTIMATOR
from aerial_gnss_ros.nodes.sightings import SightingTopics
from aerial_gnss_ros.nodes.supervised import Given, SupervisedNode
from aerial_gnss_ros.nodes.timings import Timings, Waits
from aerial_gnss_ros.text.sentences import counted, utc

DETECTIONS = "detections"
SENT_ONCE = (
    "camera_info",
    "home",
    "tf_static",
)  # latched or repeated: it may be silent after the first message
ADVANCE_S = 0.02  # longest delay until a message waiting for telemetry is given up
RECORDED_S = 600.0  # no camera's clock lags this far
PREDICT_S = 0.1  # longest delay of a due prediction


class EstimatorNode(SupervisedNode):
    """Drives the core's estimator with messages and publishes what it returns.

    Args:
        given: parameter files and namespace.

    Attributes:
        timings: milliseconds of each stage; `wait` is the wait for telemetry at the image's time.

    Raises:
        AerialGnssError: a parameter or the state file cannot be used.
    """

    GROUPS = ("classes", "references")

    def __init__(self, given: Given | None = None) -> None:
        given = given or Given()
        super().__init__(ESTIMATOR, given)
        self._config = estimator_config(self.values)
        self._estimator = Estimator(self._config, session=given.session)
        self._feed = Feed(self._config, self._estimator, self.warn_seldom)
        correlation_time_s = self._config.noise.value("correlation_time_s")
        self._positions = PositionTopics(
            self, self._config.map, self._config.updates, correlation_time_s
        )
        self._departures = self._positions.departures
        drone = self._config.sightings.drone
        self._sightings = (
            SightingTopics(self, drone, self._estimator, self.values) if drone else None
        )
        self._area = load_area(self._config.detections.area)
        overviews = self.announce(*OVERVIEW, qos.latched())
        self._overviews = OnDemandTopic(overviews, self._overview_message)
        self.timings = Timings()
        self._waits = Waits()
        self._images = 0
        self._overdue = Overdue()
        self._versioned: list[Input] = []
        for subscription in self._feed.subscriptions:
            self._subscribe(subscription)
        if self._versioned:
            self.every(1.0, self._follow_versions)
        self.follow(self._usable, self._set_config)
        self.every(ADVANCE_S, self._advance)
        self.every(PREDICT_S, self._predict)
        self.every(LOOK_S, self._overviews.look)
        self.claim(OVERVIEW[0])
        self.get_logger().info(self._start_message())

    def destroy_node(self) -> None:
        """Save the robots' labels if a state file is set, then destroy the node."""
        self._estimator.flush()
        self.log_sentences(self._estimator.take_events())
        super().destroy_node()

    def _subscribe(self, subscription: Subscription) -> None:
        reliable = subscription.name == DETECTIONS
        expected = ALWAYS if subscription.required else OPTIONAL
        source = self.listen(
            subscription.name,
            subscription.topic,
            subscription.msgtype,
            qos.detections() if reliable else qos.sensor(subscription.depth),
            lambda msg: self._take(subscription, msg),
            expected=ONCE if subscription.name in SENT_ONCE else expected,
            sent_once=subscription.sent_once,
        )
        if subscription.versioned:
            self._versioned.append(source)

    def _follow_versions(self) -> None:
        """Switch to `<topic>_v<n>` if only that is published: PX4 since 1.16."""
        silent = [source for source in self._versioned if not source.arrivals.count]
        if not silent:
            return
        names = [name for name, _ in self.get_topic_names_and_types()]
        present = [name for name in names if self.count_publishers(name)]
        for source in silent:
            found = newest_version(source.topic, present)
            if found != source.topic:
                self.listen_instead(source, found)

    def _take(self, subscription: Subscription, msg: Any) -> None:
        now_ns = self.now_ns()
        if (
            now_ns == 0
        ):  # simulated time has not begun: messages stamped on arrival have no stamp yet
            self.warn_seldom(
                "messages arrive, but there is no time yet: use_sim_time is true and /clock "
                "is silent"
            )
            return
        if subscription.name == DETECTIONS:
            stamp_ns = nanoseconds(msg.header.stamp)
            self._waits.begin(stamp_ns, time.perf_counter())
            if not self.get_clock().ros_time_is_active:
                self._tell_of_recording(stamp_ns, now_ns)
        subscription.handle(msg, now_ns)
        self._advance()

    def _tell_of_recording(self, stamp_ns: int, now_ns: int) -> None:
        """Report a recording that is played without its clock, by the minute: not each image."""
        recent = now_ns - stamp_ns < RECORDED_S * SECOND_NS
        if recent or stamp_ns == UNFILLED_NS or not self._feed.stamps_on_arrival:
            return
        self.warn_seldom(
            f"images are stamped {utc(stamp_ns)[:16]} UTC, but this node's clock says "
            f"{utc(now_ns)[:10]}: {', '.join(self._feed.stamps_on_arrival)}, stamped on arrival, "
            "cannot match. If this is a recording, start the nodes with use_sim_time:=true and "
            "play it with /clock (`aerial-gnss play BAG`, or `ros2 bag play --clock`)"
        )

    def _advance(self) -> None:
        now_ns = self.now_ns()
        if now_ns == 0:
            return
        started = time.perf_counter()
        results = self._estimator.advance(now_ns, self.steady_ns())
        spent_ms = (time.perf_counter() - started) * 1e3
        for result in results:
            waited_ms = self._waits.end(result.stamp_ns, started)
            self.timings.add({"wait": waited_ms, "estimate": spent_ms / len(results)})
            self._publish(result)
        if self._sightings is not None and results:
            self._sightings.send(results[-1].datum)
        self.log_sentences(self._estimator.take_events())

    def _publish(self, result: FrameResult) -> None:
        self._images += 1
        if (
            self._images == 1
        ):  # there is time now for work that a later image would have to wait for
            begun(linear_assignment.solver, "importing")
        started = time.perf_counter()
        self._overdue.processed(result.stamp_ns, self._passing_ns())
        self._send(result)
        self.timings.add({**result.timings_ms, "publish": (time.perf_counter() - started) * 1e3})

    def _send(self, result: FrameResult) -> None:
        result = self._positions.send(result)
        self._overviews.keep(result)  # nobody sees more than one in LOOK_S

    def _overview_message(self, result: FrameResult) -> Any:
        """Return a result as JSON text for the page, by this node's clock."""
        complaints = [self._estimator.complaint, *self._estimator.health.complaints]
        lights = input_lights(self._estimator.inputs, complaints)
        seen = self._estimator.overview(result)
        text = overview_text(seen, self.now_ns(), self._area, lights)
        return message(OVERVIEW[1], {"data": text})

    def _predict(self) -> None:
        """Publish predicted positions while no image arrives, so that no message grows old."""
        stamp_ns = self._overdue.due(self._passing_ns())
        if stamp_ns is None or not self._departures.present:
            return
        nothing = FrameResult(stamp_ns, "", (), (), None)  # the estimator has restarted
        self._send(self._estimator.predicted(stamp_ns) or nothing)

    def _passing_ns(self) -> int:
        """Return a time for differences: simulated time, or else a clock that is never stepped."""
        return self.now_ns() if self.get_clock().ros_time_is_active else self.steady_ns()

    def fixed(self, name: str) -> str:
        """Return why a parameter cannot be changed now; empty if it can."""
        if name.split(".", maxsplit=1)[0] != "robots":
            return ""
        return (
            f"{name} cannot be changed while the node runs: labels are bound when robots are first "
            "confirmed. Restart it with the new robots."
        )

    def _usable(self, values: Mapping[str, Any]) -> EstimatorConfig:
        """Return a configuration of which also files and topics can be used.

        Raises:
            ConfigError: they cannot.
        """
        config = estimator_config(values)
        load_area(config.detections.area)
        for one in config.references:
            if one.topic:
                self.resolved(one.topic)
        return config

    def _set_config(self, config: EstimatorConfig) -> None:
        """Use a configuration that differs in parameters that can be changed while running."""
        level_m, former_m = config.water_level.value_m, self._config.water_level.value_m
        if config.detections.area != self._config.detections.area:
            self._area = load_area(config.detections.area)
        self._config = config
        self._estimator.reconfigure(config)
        if self._sightings is not None:
            self._sightings.use(self.values)
        self._feed.reconfigure(config)
        self._follow_references()
        if level_m != former_m:
            self._estimator.add_water_level(Scalar(self.now_ns(), level_m))

    def _follow_references(self) -> None:
        """Listen to the references that send fixes now."""
        wanted = {one.name: one for one in self._feed.subscriptions if is_reference(one.name)}
        for source in [one for one in self.inputs if is_reference(one.name)]:
            one = wanted.get(source.name)
            if one is None or self.resolved(one.topic) != source.topic:
                self.listen_no_more(source)
            else:
                del wanted[source.name]
        for subscription in wanted.values():
            self._subscribe(subscription)

    def _start_message(self) -> str:
        heard = ", ".join(f"{source.name} {source.topic}" for source in self.inputs)
        out = self.resolve_topic_name("robots")
        return f"method {self._config.method}; {heard} -> {out}/<id>/geo_pose, fix, odom"

    def judge(self, source: Input, status: Status) -> Status:
        """Add the core's judgement of an input: its state, and unusable messages."""
        known = self._estimator.inputs.get(source.name)
        if known is None:
            return status
        values = {
            **status.values,
            "state": str(known.state),
            "unusable": known.bad,
            "unordered": known.unordered,
        }
        if known.state is InputState.BAD:
            words = f"the last message was unusable ({known.bad} of {known.count}): {known.trouble}"
            return Status(status.name, ERROR, words, values)
        if known.state is InputState.STALE and status.level == OK and source.expected == ALWAYS:
            return Status(status.name, WARN, "its stamps lag behind the images", values)
        return Status(status.name, status.level, status.message, values)

    def statuses(self) -> list[Status]:
        """Return lines for inputs without a topic, for each robot, and for refusals."""
        listened = {source.name for source in self.inputs}
        still = [
            Status(name, OK, str(known.state))
            for name, known in self._estimator.inputs.items()
            if name not in listened
        ]
        now_ns = self.now_ns()
        robots = [_robot_status(summary(one), now_ns) for one in self._departures.present]
        return [*still, *robots, self._positions_status(len(robots)), self._health_status()]

    def _health_status(self) -> Status:
        """Return the consistency of the stated noise, and the platform's errors."""
        health = self._estimator.health
        values: dict[str, Any] = {"innovation_ratio": health.fit.ratio}
        for error in health.platform:
            scale, unit = (math.degrees(1.0), "_deg") if error.is_angle else (1.0, "")
            values[f"{error.name}{unit}"] = scale * error.value
            values[f"{error.name}_sigma{unit}"] = scale * error.sigma
        if health.complaints:
            return Status("stated noise", WARN, " ".join(health.complaints), values)
        known = not math.isnan(health.fit.ratio)
        return Status("stated noise", OK, "fits" if known else "not judged yet", values)

    def _positions_status(self, robots: int) -> Status:
        counts = {str(reason): n for reason, n in sorted(self._estimator.counts.items()) if n}
        words = counted(robots, "robot") if self._images else "no image yet"
        values: dict[str, Any] = {"method": self._config.method, "images": self._images}
        values |= {"boxes": self._estimator.boxes, "boxes_used": self._estimator.used}
        values |= {f"rejected_{reason}": n for reason, n in counts.items()}
        values |= {f"unconfirmed_{why}": n for why, n in sorted(self._estimator.causes.items())}
        values |= {f"images_{why}": n for why, n in sorted(self._estimator.dropped.items())}
        values |= dict(sorted(self._estimator.happened.items()))
        values |= {f"ms_{stage}": mean for stage, mean in self.timings.means_ms().items()}
        values |= {f"ms_p95_{stage}": p95 for stage, p95 in self.timings.p95_ms().items()}
        level = OK if self._images else STALE
        silent_s = self._overdue.seconds(self._passing_ns())
        if silent_s:
            level, words = WARN, f"no image for {silent_s:.0f} s: {words} predicted"
        complaint = self._estimator.complaint
        if complaint:
            level, words = max(level, WARN), f"{words}; {complaint}"
        return Status("positions", level, words, values)


def _robot_status(robot: RobotSummary, now_ns: int) -> Status:
    values = {
        "state": str(robot.state),
        "class": robot.class_id,
        "last_seen_s": (now_ns - robot.last_seen_ns) / SECOND_NS,
        "sigma_m": robot.sigma_m,
    }
    level = OK if robot.state is State.CONFIRMED else WARN
    return Status(f"robot {robot.robot_id}", level, str(robot.state), values)
