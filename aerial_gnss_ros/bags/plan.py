# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Selects the recorded topics for a replay; reports missing ones beforehand."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from aerial_gnss_ros.adapters.feed import Subscription
from aerial_gnss_ros.adapters.versions import newest_version
from aerial_gnss_ros.bags.one_drone import refuse_two_drones
from aerial_gnss_ros.bags.reader import BagReader, Topic
from aerial_gnss_ros.core.values.errors import InputError

DETECTIONS = "detections"
IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
_TOPICS_SHOWN = 40
_TYPED = ("fix", "attitude", "gimbal", "height")  # inputs whose message type is a parameter


@dataclass(frozen=True)
class Plan:
    """The topics that a replay reads.

    Attributes:
        routes: inputs of the estimator by absolute topic; without `detections` if the detector runs
            on images.
        detections: the input for boxes, recorded or detected.
        image_topic: images for the detector; None if recorded detections are used.
    """

    routes: dict[str, Subscription]
    detections: Subscription
    image_topic: str | None

    @property
    def topics(self) -> frozenset[str]:
        """All topics that are read."""
        images = [self.image_topic] if self.image_topic else []
        return frozenset([*self.routes, *images])


def make_plan(
    bag: BagReader,
    subscriptions: Sequence[Subscription],
    image_topic: str,
    *,
    namespace: str = "",
    detect: bool = False,
) -> Plan:
    """Return the topics to read.

    Args:
        bag: open.
        subscriptions: the estimator's inputs.
        image_topic: of raw images, relative or absolute; compressed ones are below it.
        namespace: of relative recorded topics.
        detect: run the detector even if the bag has detections.

    Raises:
        InputError: a needed topic is missing (all missing ones are named) or has another type, the
            bag has neither detections nor images, or bags are of two drones.
    """
    inputs = {s.name: s for s in subscriptions}
    boxes = inputs.pop(DETECTIONS)
    recorded = resolve(boxes.topic, namespace)
    use_recorded = not detect and _has(bag, recorded)
    images = None if use_recorded else _images(bag, image_topic, boxes, namespace)
    found = [(recorded_name(bag, s, namespace), s) for s in inputs.values()]
    missing = [s for topic, s in found if s.required and not _has(bag, topic)]
    if missing:
        raise InputError(_missing_sentence(bag, missing, namespace))
    routes: dict[str, Subscription] = {}
    for topic, subscription in [*found, *([(recorded, boxes)] if use_recorded else [])]:
        if _has(bag, topic):
            _check_type(bag, topic, subscription)
            routes[topic] = _both(routes.get(topic), subscription)
    if len(bag.paths) > 1:
        refuse_two_drones(bag, [topic for topic, one in found if one.name == "fix"])
    return Plan(routes, boxes, images)


def recorded_name(bag: BagReader, subscription: Subscription, namespace: str) -> str:
    """Return the absolute topic of an input, its newest version if the bag has versions."""
    name = resolve(subscription.topic, namespace)
    if not subscription.versioned:
        return name
    return newest_version(name, [topic for topic in bag.topics if _has(bag, topic)])


def _both(first: Subscription | None, second: Subscription) -> Subscription:
    """Return one subscription for two inputs of one topic: position and attitude of one pose."""
    if first is None:
        return second
    one = first.handle

    def handle(msg: Any, arrival_ns: int) -> None:
        one(msg, arrival_ns)
        second.handle(msg, arrival_ns)

    return replace(first, name=f"{first.name} and {second.name}", handle=handle)


def resolve(topic: str, namespace: str) -> str:
    """Return a topic's absolute name, as ROS resolves it."""
    if topic.startswith("/"):
        return topic
    prefix = namespace.strip("/")
    return f"/{prefix}/{topic}" if prefix else f"/{topic}"


def _has(bag: BagReader, topic: str) -> bool:
    return topic in bag.topics and bag.topics[topic].count > 0


def _images(bag: BagReader, topic: str, boxes: Subscription, namespace: str) -> str:
    raw = resolve(topic, namespace)
    compressed = raw + "/compressed"
    for name, msgtype in ((raw, IMAGE), (compressed, COMPRESSED)):
        if _has(bag, name):
            found = bag.topics[name].msgtype
            if found != msgtype:
                raise InputError(
                    f"{name} has message type {found}, not {msgtype}; set image.topic in --params "
                    f"to the images. {_listing(bag)}"
                )
            return name
    if _has(bag, resolve(boxes.topic, namespace)):
        raise InputError(
            f"{_names(bag)} has no images on {raw} or {compressed}, only recorded detections; "
            "replay uses these without --model."
        )
    raise InputError(
        f"{_names(bag)} has neither detections on {resolve(boxes.topic, namespace)} nor images on "
        f"{raw} or {compressed}; {_advice(bag, [topic, boxes.topic], namespace)} {_listing(bag)}"
    )


def _check_type(bag: BagReader, topic: str, subscription: Subscription) -> None:
    found = bag.topics[topic].msgtype
    if found != subscription.msgtype:
        if subscription.name.split("_")[0] == "depth":
            raise InputError(
                f"{topic} has message type {found}, but depths must be {subscription.msgtype}; "
                "publish it as such, or remove it from depth.topics."
            )
        group = "camera" if subscription.name == "camera_info" else subscription.name
        keys = f"{group}.type or {group}.topic" if group in _TYPED else f"{group}.topic"
        raise InputError(
            f"{topic} has message type {found}, but {subscription.name} is set to "
            f"{subscription.msgtype}; set {keys} in --params, or choose another --vehicle."
        )


def _missing_sentence(bag: BagReader, missing: Sequence[Subscription], namespace: str) -> str:
    wanted = ", ".join(f"{resolve(s.topic, namespace)} ({s.name}, {s.msgtype})" for s in missing)
    advice = _advice(bag, [s.topic for s in missing], namespace)
    return f"{_names(bag)} lacks {wanted}; {advice} {_listing(bag)}"


def _advice(bag: BagReader, wanted: Sequence[str], namespace: str) -> str:
    """Return advice: the namespace that has the wanted topics, if there is one."""
    prefixes = {
        name[: -len(topic) - 1]
        for name in bag.topics
        for topic in wanted
        if name.endswith("/" + topic)
    }
    fitting = sorted(
        prefix
        for prefix in prefixes
        if prefix.strip("/") != namespace.strip("/")
        and not prefix.endswith("/truth")  # truth of a simulated flight, not a measurement
        and any(_has(bag, f"{prefix}/{topic}") for topic in wanted)
    )
    if len(fitting) == 1:
        return f"try --namespace {fitting[0].strip('/') or '/'}."
    return "give the topics' names with --params or --vehicle, or their --namespace."


def _names(bag: BagReader) -> str:
    return " with ".join(str(path) for path in bag.paths)


def _listing(bag: BagReader) -> str:
    lines: Iterable[Topic] = list(bag.topics.values())[:_TOPICS_SHOWN]
    if not lines:
        return "It holds no topics at all."
    shown = ", ".join(f"{t.name} ({t.msgtype}, {t.count})" for t in lines)
    more = len(bag.topics) - _TOPICS_SHOWN
    return f"It holds {shown}{f' and {more} more' if more > 0 else ''}."
