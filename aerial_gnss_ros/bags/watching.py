# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Passes recorded telemetry to a monitor; reports topics that are missing or of another type."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from aerial_gnss_ros.adapters.feed import Subscription
from aerial_gnss_ros.bags.plan import recorded_name, resolve
from aerial_gnss_ros.bags.reader import BagReader
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.preflight.monitor import InputMonitor


def watch_bag(
    bag: BagReader,
    subscriptions: Sequence[Subscription],
    monitor: InputMonitor,
    *,
    namespace: str = "",
    until_s: float | None = None,
    on_message: Callable[[int], None] = lambda _done: None,
) -> tuple[int, dict[str, str]]:
    """Read a bag's telemetry.

    Args:
        bag: open.
        subscriptions: of the feed that drives the monitor.
        monitor: receives it.
        namespace: that relative topics were recorded in.
        until_s: end of reading after the bag's start, s; None: all.
        on_message: takes the number of messages read so far.

    Returns:
        The log time of the last message read, ns, and sentences by input about topics that cannot
        be read.

    Raises:
        InputError: none of the topics is in the bag, or the bag is damaged.
    """
    routes, problems = route(bag, subscriptions, namespace)
    if not routes:
        wanted = ", ".join(resolve(s.topic, namespace) for s in subscriptions)
        raise InputError(
            f"the bag has none of {wanted}: it is from another vehicle or namespace; `aerial-gnss "
            "doctor` with the same bag proposes one."
        )
    end_ns = bag.start_ns
    limit_ns = None if until_s is None else bag.start_ns + round(until_s * 1e9)
    for done, recorded in enumerate(bag.messages(set(routes)), start=1):
        if limit_ns is not None and recorded.log_ns > limit_ns:
            break
        end_ns = recorded.log_ns
        message = recorded.message()
        for subscription in routes[recorded.topic]:
            monitor.arriving(subscription.name, recorded.log_ns)
            subscription.handle(message, recorded.log_ns)
        monitor.advance()
        on_message(done)
    monitor.advance(final=True)
    return end_ns, problems


def route(
    bag: BagReader, subscriptions: Sequence[Subscription], namespace: str
) -> tuple[dict[str, list[Subscription]], dict[str, str]]:
    """Return inputs by recorded topic (one may serve several), and errors of the others."""
    routes: dict[str, list[Subscription]] = {}
    problems: dict[str, str] = {}
    for subscription in subscriptions:
        name = recorded_name(bag, subscription, namespace)
        topic = bag.topics.get(name)
        if topic is None or not topic.count:
            problems[subscription.name] = f"no messages on {name}"
        elif topic.msgtype != subscription.msgtype:
            problems[subscription.name] = (
                f"{name} carries {topic.msgtype}, not {subscription.msgtype}"
            )
        else:
            routes.setdefault(name, []).append(subscription)
    return routes, problems


def message_count(bag: BagReader, subscriptions: Sequence[Subscription], namespace: str) -> int:
    """Return the greatest number of messages that `watch_bag` reads."""
    return sum(bag.topics[name].count for name in route(bag, subscriptions, namespace)[0])
