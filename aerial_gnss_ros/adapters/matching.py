# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Matches vehicle profiles and namespaces with existing topics, by name and type."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from aerial_gnss_ros.adapters.feed import Subscription
from aerial_gnss_ros.adapters.kinds import ATTITUDE, FIX, GIMBAL, HEIGHT, Kind

DETECTIONS = "detections"
CAMERA_INFO_TYPE = "sensor_msgs/msg/CameraInfo"
IMAGE_TYPES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")

# This package's results and a simulation's truth look like inputs but are not.
_NOT_INPUTS = re.compile(r".*/(robots|truth)/.*")
_KINDS: Mapping[str, Mapping[str, Kind[Any, Any]]] = {
    "fix": FIX,
    "attitude": ATTITUDE,
    "gimbal": GIMBAL,
    "height": HEIGHT,
}


@dataclass(frozen=True)
class SeenTopic:
    """A topic of a bag or of a live graph.

    Attributes:
        name: absolute.
        msgtype: such as `sensor_msgs/msg/NavSatFix`.
        rate_hz: messages a second; 0 if unknown.
        count: messages seen.
        trouble: why its messages cannot be read; empty if they can.
    """

    name: str
    msgtype: str
    rate_hz: float = 0.0
    count: int = 0
    trouble: str = ""


@dataclass(frozen=True)
class Fit:
    """How well a profile matches in a namespace.

    Attributes:
        profile: its name.
        namespace: without slashes around it; empty for none.
        matched: topics by input.
        wrong_type: topics by input that exist with another type.
        missing: absent inputs that positions need.
    """

    profile: str
    namespace: str
    matched: Mapping[str, str]
    wrong_type: Mapping[str, SeenTopic]
    missing: tuple[Subscription, ...]

    @property
    def score(self) -> int:
        """Higher is a better match."""
        return 2 * len(self.matched) - 2 * len(self.missing) - len(self.wrong_type)


def fits(profiles: Mapping[str, Sequence[Subscription]], seen: Sequence[SeenTopic]) -> list[Fit]:
    """Return each profile in its best namespace, the best profile first.

    Args:
        profiles: the feed's subscriptions by profile.
        seen: the existing topics.
    """
    found = [
        max(
            (_fit(name, namespace, inputs, seen) for namespace in _namespaces(inputs, seen)),
            key=lambda fit: (fit.score, -len(fit.namespace)),
        )
        for name, inputs in profiles.items()
    ]
    return sorted(found, key=lambda fit: (-fit.score, fit.profile))


def other_drones(
    profiles: Mapping[str, Sequence[Subscription]], seen: Sequence[SeenTopic], found: Fit
) -> list[Fit]:
    """Return the best complete profile of each other namespace with a drone's position.

    Args:
        profiles: the feed's subscriptions by profile.
        seen: the existing topics.
        found: the profile of the first drone.
    """
    others: dict[str, Fit] = {}
    for name, inputs in profiles.items():
        for namespace in _namespaces(inputs, seen):
            fit = _fit(name, namespace, inputs, seen)
            if namespace == found.namespace or fit.missing or "fix" not in fit.matched:
                continue
            if namespace not in others or fit.score > others[namespace].score:
                others[namespace] = fit
    return [others[namespace] for namespace in sorted(others)]


def candidates(source: str, seen: Iterable[SeenTopic]) -> list[tuple[SeenTopic, str]]:
    """Return candidate topics for an input, each with the name of its type in the parameters."""
    if source == "camera_info":
        return [(t, "") for t in seen if t.msgtype == CAMERA_INFO_TYPE and _is_input(t)]
    kinds = _KINDS.get(source, {})
    return [
        (topic, kind)
        for topic in seen
        if _is_input(topic)
        for kind, described in kinds.items()
        if described.msgtype == topic.msgtype
    ]


def _is_input(topic: SeenTopic) -> bool:
    return _NOT_INPUTS.fullmatch(topic.name) is None


def _namespaces(inputs: Sequence[Subscription], seen: Sequence[SeenTopic]) -> list[str]:
    found = {""}
    for topic in filter(_is_input, seen):
        name = re.sub(r"_v\d+$", "", topic.name)
        for subscription in inputs:
            if not subscription.topic.startswith("/") and name.endswith("/" + subscription.topic):
                found.add(name[: -len(subscription.topic)].strip("/"))
    return sorted(found)


def _fit(
    profile: str, namespace: str, inputs: Sequence[Subscription], seen: Sequence[SeenTopic]
) -> Fit:
    topics = {topic.name: topic for topic in seen}
    matched: dict[str, str] = {}
    wrong: dict[str, SeenTopic] = {}
    missing: list[Subscription] = []
    for subscription in inputs:
        if subscription.name == DETECTIONS:
            continue
        topic = _topic(topics, subscription, namespace)
        if topic is not None and topic.msgtype == subscription.msgtype:
            matched[subscription.name] = topic.name
            continue
        if topic is not None:
            wrong[subscription.name] = topic
        if subscription.required:
            missing.append(subscription)
    return Fit(profile, namespace, matched, wrong, tuple(missing))


def _topic(
    topics: Mapping[str, SeenTopic], subscription: Subscription, namespace: str
) -> SeenTopic | None:
    name = subscription.topic
    if not name.startswith("/"):
        name = f"/{namespace}/{name}" if namespace else f"/{name}"
    if name in topics or not subscription.versioned:
        return topics.get(name)
    pattern = re.compile(re.escape(name) + r"_v(\d+)")
    versions = [(int(m[1]), t) for t in topics if (m := pattern.fullmatch(t))]
    return topics[max(versions)[1]] if versions else None
