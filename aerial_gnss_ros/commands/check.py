# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss check`: reports drone and camera pose in words, so that signs can be verified."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Any

from aerial_gnss_ros.adapters.feed import Feed, Subscription
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.stated_datum import with_stated_datum
from aerial_gnss_ros.bags.watching import message_count, watch_bag
from aerial_gnss_ros.commands.check_report import Check, as_json, as_text, one_line
from aerial_gnss_ros.commands.configuration import add_arguments as add_configuration
from aerial_gnss_ros.commands.configuration import configuration
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.models.motion_model import fastest
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.nodes import require_ros
from aerial_gnss_ros.preflight.image_test import image_test
from aerial_gnss_ros.preflight.monitor import InputMonitor
from aerial_gnss_ros.preflight.sign_tests import sign_tests

HELP = "report in words where the camera points, and test signs and references"
NOT_GOOD = 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Status 0: the camera's pose is known, no input is missing and no test failed; 1: "
        "otherwise. docs/howto/field_check.md guides a pilot through two minutes at the field."
    )
    parser.add_argument(
        "bags", type=Path, nargs="*", metavar="BAG",
        help="recorded bags (default: the live topics)",
    )  # fmt: skip
    parser.add_argument(
        "--seconds", type=float, default=10.0, metavar="S",
        help="duration for live topics, s (%(default)g)",
    )  # fmt: skip
    parser.add_argument(
        "--at",
        type=float,
        metavar="S",
        help="read a bag up to this time after its start, s (default: its end)",
    )
    add_configuration(parser)
    parser.add_argument("--json", action="store_true", help="print the report as JSON")


def run(args: argparse.Namespace) -> int:
    """Check a bag or the live topics."""
    if not (math.isfinite(args.seconds) and args.seconds > 0.0):
        raise InputError(f"--seconds must be above 0, not {args.seconds:g}.")
    if args.at is not None and not args.at > 0.0:
        raise InputError(f"--at must be above 0 s, not {args.at:g}.")
    config = configuration(args).estimator
    check = _of_bag(args, config) if args.bags else _live(args, config)
    print(json.dumps(as_json(check), indent=2) if args.json else as_text(check))
    return 0 if check.good else NOT_GOOD


def _of_bag(args: argparse.Namespace, config: EstimatorConfig) -> Check:
    with open_bag(args.bags) as bag:
        config = with_stated_datum(config, bag)
        monitor, notes = InputMonitor(config), list[str]()
        feed = Feed(config, monitor, notes.append)
        total = message_count(bag, feed.subscriptions, args.namespace)
        with progress("reading", total, "messages") as report:
            end_ns, problems = watch_bag(
                bag,
                feed.subscriptions,
                monitor,
                namespace=args.namespace,
                until_s=args.at,
                on_message=report,
            )
    return _judged(config, monitor, feed.subscriptions, problems, end_ns, notes)


def _live(args: argparse.Namespace, config: EstimatorConfig) -> Check:
    require_ros()
    from aerial_gnss_ros.nodes.listening import listen

    monitor, notes, newest = InputMonitor(config), list[str](), [0]
    feed = Feed(config, monitor, notes.append)

    def receive(subscription: Subscription, message: Any, now_ns: int) -> None:
        monitor.arriving(subscription.name, now_ns)
        subscription.handle(message, now_ns)
        monitor.advance()

    def tick(now_ns: int) -> None:
        newest[0] = now_ns
        print(one_line(monitor), file=sys.stderr, flush=True)

    problems = listen(feed.subscriptions, args.namespace, args.seconds, receive, tick)
    monitor.advance(final=True)
    return _judged(config, monitor, feed.subscriptions, problems, newest[0], notes)


def _judged(
    config: EstimatorConfig,
    monitor: InputMonitor,
    subscriptions: tuple[Subscription, ...],
    problems: dict[str, str],
    now_ns: int,
    notes: list[str],
) -> Check:
    tests = (
        *sign_tests(list(monitor.states)),
        image_test([*monitor.boxes.images], fastest(config)),
    )
    all_notes = [*monitor.events, *sorted(monitor.troubles), *dict.fromkeys(notes)]
    return Check(config, monitor, subscriptions, problems, now_ns, tests, all_notes)
