# SPDX-License-Identifier: Apache-2.0
"""What both nodes share: parameters, watched inputs, QoS reports, diagnostics once a second."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, qos_policy_name_from_kind

from aerial_gnss_ros.adapters.parameter_files import read, ros_parameters
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.arrivals import SECOND_NS, SILENCE_S, Arrivals
from aerial_gnss_ros.nodes.parameters import declare, follow_changes, own_values
from aerial_gnss_ros.nodes.ros_messages import message_class
from aerial_gnss_ros.nodes.schemas import SCHEMAS

_REPEAT_S = 30.0

OK, WARN, ERROR, STALE = (
    DiagnosticStatus.OK,
    DiagnosticStatus.WARN,
    DiagnosticStatus.ERROR,
    DiagnosticStatus.STALE,
)


@dataclass
class Input:
    """One topic that a node listens to.

    Attributes:
        name: what comes there, in words.
        topic: resolved name.
        msgtype: such as `sensor_msgs/msg/Image`.
        expected: `always`, `once` (then it may stay silent) or `never` (optional).
        hint: what to look at when nothing comes though somebody publishes.
        arrivals: when messages came.
        lost: messages that were published and did not arrive, as the middleware counts them.
    """

    name: str
    topic: str
    msgtype: str
    expected: str
    hint: str
    arrivals: Arrivals
    lost: int = 0

    @property
    def missed(self) -> bool:
        """Whether silence on it now is worth a report."""
        if self.expected == "once":
            return self.arrivals.count == 0
        return self.expected == "always"


@dataclass(frozen=True)
class Given:
    """What a process gives its nodes besides ROS arguments.

    Attributes:
        files: parameter files, the later one wins; `--ros-args` beats them all.
        namespace: of the nodes; None: from ROS arguments.
    """

    files: Sequence[Path] = ()
    namespace: str | None = None


@dataclass(frozen=True)
class Status:
    """One line of /diagnostics."""

    name: str
    level: bytes
    message: str
    values: Mapping[str, Any] = field(default_factory=dict)


class SupervisedNode(Node):  # type: ignore[misc]  # rclpy has no complete types
    """A node with checked parameters, watched inputs and diagnostics.

    Args:
        name: of the node, in `SCHEMAS`.
        given: parameter files and namespace.

    Raises:
        ConfigError: a parameter is unknown, of the wrong type or out of range.
    """

    def __init__(self, name: str, given: Given) -> None:
        own = ros_parameters(given.files, name, given.namespace or "/")
        super().__init__(
            name,
            namespace=given.namespace,
            parameter_overrides=[Parameter(key, value=value) for key, value in own.items()],
        )
        overrides = {key: item.value for key, item in self._parameter_overrides.items()}
        self.values = read(given.files, SCHEMAS, self.get_namespace())[name]
        self.values |= own_values(name, overrides)
        declare(self, SCHEMAS[name], self.values)
        self.inputs: list[Input] = []
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._said: dict[str, int] = {}
        self._diagnostics = self.create_publisher(
            DiagnosticArray, "/diagnostics", qos.diagnostics()
        )
        self.every(1.0, self._each_second)

    def every(self, seconds: float, callback: Callable[[], None]) -> None:
        """Call back periodically on the steady clock, also while simulated time stands still."""
        self.create_timer(seconds, callback, clock=self._steady)

    def follow(
        self, build: Callable[[Mapping[str, Any]], Any], apply: Callable[[Any], None]
    ) -> None:
        """Take changes of dynamic parameters.

        Args:
            build: makes a configuration of all values; raises ConfigError with the sentence that
                the caller of `ros2 param set` reads.
            apply: takes the new configuration.
        """

        def accept(values: dict[str, Any], config: Any) -> None:
            self.values = values
            apply(config)

        follow_changes(self, lambda: self.values, build, accept)

    def listen(
        self,
        name: str,
        topic: str,
        msgtype: str,
        profile: QoSProfile,
        callback: Callable[[Any], None],
        *,
        expected: str = "always",
        hint: str = "it does not send",
    ) -> Input:
        """Subscribe to a topic and watch it; see `Input` for the arguments."""
        source = Input(
            name,
            self.resolve_topic_name(topic),
            msgtype,
            expected,
            hint,
            Arrivals(self.steady_ns()),
        )

        def take(msg: Any) -> None:
            quiet_s = source.arrivals.record(self.steady_ns())
            if quiet_s is not None:
                self.get_logger().info(f"{name} is back on {source.topic} after {quiet_s:.1f} s")
            callback(msg)

        def lost(event: Any) -> None:
            source.lost = event.total_count

        events = SubscriptionEventCallbacks(
            incompatible_qos=lambda event: self._mismatch(
                source.topic, "publisher", profile, event
            ),
            message_lost=lost,
        )
        self.create_subscription(
            message_class(msgtype), topic, take, profile, event_callbacks=events
        )
        self.inputs.append(source)
        return source

    def announce(self, topic: str, msgtype: str, profile: QoSProfile) -> Publisher:
        """Return a publisher that reports subscribers which cannot be served."""
        resolved = self.resolve_topic_name(topic)
        events = PublisherEventCallbacks(
            incompatible_qos=lambda event: self._mismatch(resolved, "subscriber", profile, event)
        )
        return self.create_publisher(message_class(msgtype), topic, profile, event_callbacks=events)

    def steady_ns(self) -> int:
        """Return a clock that never jumps, ns."""
        return int(self._steady.now().nanoseconds)

    def now_ns(self) -> int:
        """Return the node's time, ns; 0 while simulated time has not begun."""
        return int(self.get_clock().now().nanoseconds)

    def warn_seldom(self, sentence: str) -> None:
        """Log a warning, the same one at most every 30 s."""
        now_ns = self.steady_ns()
        last_ns = self._said.get(sentence)
        if last_ns is None or now_ns - last_ns >= _REPEAT_S * SECOND_NS:
            self._said[sentence] = now_ns
            self.get_logger().warning(sentence)

    @abstractmethod
    def statuses(self) -> list[Status]:
        """Return this node's lines of /diagnostics, without those of its inputs."""

    def _each_second(self) -> None:
        now_ns = self.steady_ns()
        for source in self.inputs:
            if source.missed and source.arrivals.fell_silent(now_ns):
                self.get_logger().warning(self._silence(source))
        self._publish_diagnostics(now_ns)

    def _silence(self, source: Input) -> str:
        found = self.get_publishers_info_by_topic(source.topic)
        begin = (
            f"no {source.name} for {SILENCE_S:.0f} s on {source.topic} (publishers: {len(found)})"
        )
        other = sorted({info.topic_type for info in found} - {source.msgtype})
        if other:
            return f"{begin}: {', '.join(other)} comes there where {source.msgtype} is meant"
        if found:
            return f"{begin}: {source.hint}"
        return f"{begin}: start what publishes it, or remap {source.topic}"

    def _mismatch(self, topic: str, other: str, profile: QoSProfile, event: Any) -> None:
        policy = qos_policy_name_from_kind(event.last_policy_kind).lower()
        ours = str(getattr(profile, policy, "")).rsplit(".", 1)[-1].lower().replace("_", " ")
        verb = "asks for" if other == "publisher" else "offers"
        self.get_logger().warning(
            f"{topic}: a {other}'s {policy} does not fit, so nothing passes: this node {verb} "
            f"{ours or 'another one'}; set the {other}'s {policy} to {ours or 'the same'}"
        )

    def _publish_diagnostics(self, now_ns: int) -> None:
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        prefix = self.get_fully_qualified_name().lstrip("/")
        lines = [_input_status(source, now_ns) for source in self.inputs] + self.statuses()
        for line in lines:
            values = [KeyValue(key=key, value=_text(value)) for key, value in line.values.items()]
            message.status.append(
                DiagnosticStatus(
                    name=f"{prefix}: {line.name}",
                    level=line.level,
                    message=line.message,
                    hardware_id=prefix,
                    values=values,
                )
            )
        self._diagnostics.publish(message)


def _input_status(source: Input, now_ns: int) -> Status:
    arrivals = source.arrivals
    age_s = arrivals.age_s(now_ns)
    if age_s is None:
        level, words = (
            (OK, "optional, not given") if source.expected == "never" else (STALE, "never")
        )
    elif arrivals.quiet_s(now_ns) >= SILENCE_S and source.missed:
        level, words = WARN, f"silent for {age_s:.0f} s"
    else:
        level, words = OK, "received"
    values = {
        "topic": source.topic,
        "messages": arrivals.count,
        "rate_hz": arrivals.rate(now_ns),
        "age_s": "never" if age_s is None else age_s,
        "lost_in_transport": source.lost,
    }
    return Status(source.name, level, words, values)


def _text(value: Any) -> str:
    return f"{value:.3f}" if isinstance(value, float) else str(value)
