# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Base of both nodes: parameters, watched inputs, QoS reports, diagnostics once a second."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSCompatibility, QoSProfile, qos_check_compatible, qos_policy_name_from_kind

from aerial_gnss_ros.adapters.parameter_files import foreign, left_out, read, ros_parameters
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.core.values.events import ErrorText, WarningText
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.arrivals import SECOND_NS, Arrivals
from aerial_gnss_ros.nodes.diagnostics import (
    ERROR,
    OK,
    WARN,
    Status,
    diagnostic_array,
    input_status,
)
from aerial_gnss_ros.nodes.distribution import (
    PublisherEventCallbacks,
    SubscriptionEventCallbacks,
)
from aerial_gnss_ros.nodes.inputs import ALWAYS, Input, mismatch
from aerial_gnss_ros.nodes.internal_errors import InternalErrors
from aerial_gnss_ros.nodes.latched import LOOK_S, LatchedToo
from aerial_gnss_ros.nodes.names import absolute_namespace, check_topic, full_name
from aerial_gnss_ros.nodes.parameters import declare, follow_changes, own_values
from aerial_gnss_ros.nodes.rivals import Rivals
from aerial_gnss_ros.nodes.ros_arguments import parameter_files
from aerial_gnss_ros.nodes.ros_messages import message_class
from aerial_gnss_ros.nodes.schemas import SCHEMAS
from aerial_gnss_ros.text.sentences import counted

_REPEAT_S = 30.0
_MOST_SAID = 200
_NO_COUNT = 2**31 - 1


@dataclass(frozen=True)
class Given:
    """Settings of a node besides its ROS arguments.

    Attributes:
        files: parameter files, the later one wins; `--ros-args` beats them all.
        namespace: of the nodes; None: from ROS arguments.
        session: file in which the estimator keeps labels for a restart, or None.
    """

    files: Sequence[Path] = ()
    namespace: str | None = None
    session: Path | None = None


class SupervisedNode(Node):  # type: ignore[misc]  # rclpy has no complete types
    """A node with checked parameters, watched inputs and diagnostics.

    Args:
        name: of the node, in `SCHEMAS`.
        given: parameter files and namespace.

    Raises:
        ConfigError: a parameter is unknown, of the wrong type or out of range.
    """

    CHANGEABLE = False
    """Whether `fixed` decides which parameters can be changed, instead of the schema."""

    GROUPS: tuple[str, ...] = ()
    """Groups of parameters whose keys the user chooses and may change."""

    def __init__(self, name: str, given: Given) -> None:
        super().__init__(
            name,
            namespace=absolute_namespace(given.namespace),
            allow_undeclared_parameters=bool(self.GROUPS),  # `follow` refuses all others
        )
        overrides = {key: item.value for key, item in self._parameter_overrides.items()}
        self._set_ros_parameters(given, name, overrides)
        self.values = self._checked_values(name, given, overrides)
        declare(self, SCHEMAS[name], self.values, changeable=self.CHANGEABLE)
        self.inputs: list[Input] = []
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._silences: dict[str, str] = {}
        self._profiles: dict[str, QoSProfile] = {}
        self._attached: dict[str, tuple[Callable[..., None], QoSProfile, Any]] = {}
        self._latched_too = LatchedToo(self)
        self._said: dict[str, int] = {}
        self._errors = InternalErrors()
        self._rivals = Rivals(name)
        self._only_ours: list[str] = []
        self._diagnostics = self.create_publisher(
            DiagnosticArray, "/diagnostics", qos.diagnostics()
        )
        self.every(1.0, self._each_second)
        self.every(LOOK_S, self._latched_too.look)

    def _checked_values(
        self, name: str, given: Given, overrides: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Return the values of files and ROS arguments; log ignored keys of other programs."""
        told = self.get_logger().warning
        namespace = self.get_namespace()
        values = read(given.files, SCHEMAS, namespace, told)[name]
        others = foreign(parameter_files(), SCHEMAS, name, namespace)
        for key, path in others.items():
            told(left_out(path, key))
        return values | own_values(name, overrides, others)

    def fixed(self, _name: str) -> str:
        """Return why a parameter cannot be changed now; empty if it can."""
        return ""

    def _set_ros_parameters(self, given: Given, name: str, overrides: Mapping[str, Any]) -> None:
        """Set `use_sim_time` and its like from the files unless ROS arguments set them."""
        own = ros_parameters(given.files, name, self.get_namespace())
        wanted = {key: value for key, value in own.items() if key not in overrides}
        known = [Parameter(k, value=v) for k, v in wanted.items() if self.has_parameter(k)]
        for result in self.set_parameters(known):
            if not result.successful:
                raise ConfigError(result.reason)

    def begin(self) -> None:
        """Start; called when all nodes of the process exist."""

    def every(self, seconds: float, callback: Callable[[], None]) -> None:
        """Create a timer on the steady clock, which runs also while simulated time stands still."""
        self.create_timer(seconds, callback, clock=self._steady)

    def follow(
        self, build: Callable[[Mapping[str, Any]], Any], apply: Callable[[Any], None]
    ) -> None:
        """Accept changes of dynamic parameters.

        Args:
            build: creates a configuration from all values; raises ConfigError with the sentence
                that the caller of `ros2 param set` reads.
            apply: called with the new configuration.
        """

        def accept(values: dict[str, Any], config: Any) -> None:
            self.values = values
            apply(config)

        follow_changes(self, lambda: self.values, build, accept, self.fixed, self.GROUPS)

    def listen(
        self,
        name: str,
        topic: str,
        msgtype: str,
        profile: QoSProfile,
        callback: Callable[[Any], None],
        *,
        expected: str = ALWAYS,
        hint: str = "its publisher is silent",
        sent_once: bool = False,
    ) -> Input:
        """Subscribe to a topic and watch it; see `Input` for the arguments.

        With `sent_once`, a message latched before this node started is received, too.
        """
        resolved = self.resolved(topic)
        arrivals = Arrivals(self.steady_ns())
        source = Input(name, resolved, msgtype, expected, hint, arrivals)

        def receive(msg: Any) -> None:
            quiet_s = arrivals.record(self.steady_ns())
            if quiet_s is not None:
                self.get_logger().info(f"{name} is back on {source.topic} after {quiet_s:.1f} s")
            callback(msg)

        heard: Callable[..., None] = receive
        if sent_once:
            heard = self._latched_too.watch(
                name, topic, message_class(msgtype), profile.depth, receive
            )
        self._attach(source, topic, heard, profile)
        self.inputs.append(source)
        return source

    def listen_instead(self, source: Input, topic: str) -> None:
        """Switch an input to another topic."""
        callback, profile, former = self._attached.pop(source.name)
        self.destroy_subscription(former)
        self.get_logger().info(f"{source.name} is published on {topic} instead of {source.topic}")
        source.topic = topic
        self._latched_too.follow(source.name, topic)
        self._attach(source, topic, callback, profile)

    def listen_no_more(self, source: Input) -> None:
        """Unsubscribe from an input."""
        _, _, subscription = self._attached.pop(source.name)
        self.destroy_subscription(subscription)
        self._latched_too.forget(source.name)
        self.inputs.remove(source)

    def _attach(
        self, source: Input, topic: str, callback: Callable[..., None], profile: QoSProfile
    ) -> None:
        resolved = source.topic

        def lost(event: Any) -> None:
            # Fast DDS occasionally reports an increment of its largest integer, which ruins the
            # total: 18446744071562067973 lost of 16 was seen.
            if 0 < event.total_count_change < _NO_COUNT:
                source.lost += event.total_count_change

        events = SubscriptionEventCallbacks(
            incompatible_qos=lambda event: self._mismatch(resolved, "publisher", profile, event),
            message_lost=lost,
        )
        made = self.create_subscription(
            message_class(source.msgtype), topic, callback, profile, event_callbacks=events
        )
        self._profiles[resolved] = profile
        self._attached[source.name] = (callback, profile, made)

    def announce(self, topic: str, msgtype: str, profile: QoSProfile) -> Publisher:
        """Return a publisher that reports incompatible subscribers."""
        resolved = self.resolved(topic)
        events = PublisherEventCallbacks(
            incompatible_qos=lambda event: self._mismatch(resolved, "subscriber", profile, event)
        )
        return self.create_publisher(message_class(msgtype), topic, profile, event_callbacks=events)

    def resolved(self, topic: str) -> str:
        """Return a topic's full name after remapping.

        Raises:
            ConfigError: the name is invalid.
        """
        check_topic(topic)
        return str(self.resolve_topic_name(topic))

    def steady_ns(self) -> int:
        """Return a clock that never jumps, ns."""
        return int(self._steady.now().nanoseconds)

    def now_ns(self) -> int:
        """Return the node's time, ns; 0 while simulated time has not begun."""
        return int(self.get_clock().now().nanoseconds)

    def survive(self, error: Exception) -> None:
        """Count an exception raised by a callback, and log it the first time.

        Raises:
            Exception: the error itself, if there are too many to continue.
        """
        sentence = self._errors.add(error)
        if sentence:
            self.get_logger().error(sentence)

    def claim(self, topic: str) -> None:
        """Watch for other publishers on a topic of this node."""
        self._only_ours.append(self.resolved(topic))

    def warn_seldom(self, sentence: str) -> None:
        """Log a warning, each at most every 30 s."""
        now_ns = self.steady_ns()
        last_ns = self._said.get(sentence)
        if last_ns is None or now_ns - last_ns >= _REPEAT_S * SECOND_NS:
            self._said.pop(sentence, None)  # the newest is the last one
            self._said[sentence] = now_ns
            if len(self._said) > _MOST_SAID:  # sentences that contain numbers are always new
                del self._said[next(iter(self._said))]
            self.get_logger().warning(sentence)

    def log_sentences(self, sentences: Iterable[str]) -> None:
        """Log sentences of the core, each by how serious its type says it is."""
        for sentence in sentences:
            if isinstance(sentence, ErrorText):
                self.get_logger().error(sentence)
            elif isinstance(sentence, WarningText):
                self.get_logger().warning(sentence)
            else:
                self.get_logger().info(sentence)

    @abstractmethod
    def statuses(self) -> list[Status]:
        """Return this node's lines of /diagnostics, without those of its inputs."""

    def advice(self, _source: Input) -> str:
        """Return the node's own explanation of a silent input; empty without one."""
        return ""

    def judge(self, _source: Input, status: Status) -> Status:
        """Return the status line of an input with the node's own judgement."""
        return status

    def _each_second(self) -> None:
        now_ns = self.steady_ns()
        for source in self.inputs:
            if source.missed and source.arrivals.fell_silent(now_ns):
                self._report_silence(source)
        self._look_for_rivals()
        lines = [self.judge(source, self._status(source, now_ns)) for source in self.inputs]
        lines.append(self._node_status())
        self._diagnostics.publish(
            diagnostic_array(
                self.get_fully_qualified_name(),
                self.get_clock().now().to_msg(),
                lines + self.statuses(),
            )
        )

    def _look_for_rivals(self) -> None:
        publishers = {
            topic: [
                full_name(info.node_name, info.node_namespace)
                for info in self.get_publishers_info_by_topic(topic)
            ]
            for topic in self._only_ours
        }
        nodes = [full_name(*names) for names in self.get_node_names_and_namespaces()]
        sentence = self._rivals.look(self.get_fully_qualified_name(), publishers, nodes)
        if sentence:
            self.get_logger().warning(sentence)

    def _node_status(self) -> Status:
        """Return the status of the node itself: internal errors and rivals."""
        values = {"internal_errors": self._errors.count}
        if self._rivals.trouble:
            return Status("node", ERROR, self._rivals.trouble, values)
        if self._errors.count:
            words = f"{counted(self._errors.count, 'internal error')}: {self._errors.last}"
            return Status("node", WARN, words, values)
        return Status("node", OK, "no errors", values)

    def _status(self, source: Input, now_ns: int) -> Status:
        """Return an input's status line, with an explanation if it is silent."""
        status = input_status(source, now_ns)
        if not source.arrivals.silent:
            return status
        return replace(status, message=self._silences.get(source.name, status.message))

    def _report_silence(self, source: Input) -> None:
        found = self.get_publishers_info_by_topic(source.topic)
        profile = self._profiles[source.topic]
        unfit = any(
            qos_check_compatible(info.qos_profile, profile)[0] == QoSCompatibility.ERROR
            for info in found
        )
        sentence = source.silence([info.topic_type for info in found], unfit)
        advice = self.advice(source)
        self._silences[source.name] = f"{sentence}; {advice}" if advice else sentence
        self.get_logger().warning(self._silences[source.name])

    def _mismatch(self, topic: str, other: str, profile: QoSProfile, event: Any) -> None:
        policy = qos_policy_name_from_kind(event.last_policy_kind).lower()
        ours = getattr(getattr(profile, policy, None), "name", "").lower().replace("_", " ")
        self.get_logger().warning(mismatch(topic, other, policy, ours))
