# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss doctor`: proposes the vehicle profile for a bag or a live graph, ready to paste."""

from __future__ import annotations

import argparse
import json
import math
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from aerial_gnss_ros.adapters.feed import Feed, Subscription
from aerial_gnss_ros.adapters.matching import (
    IMAGE_TYPES,
    Fit,
    SeenTopic,
    candidates,
    fits,
    other_drones,
)
from aerial_gnss_ros.adapters.parameter_files import read
from aerial_gnss_ros.adapters.vehicles import vehicle_file, vehicle_names
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.survey import survey
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.config import detector_config
from aerial_gnss_ros.nodes import require_ros
from aerial_gnss_ros.nodes.schemas import DETECTOR, ESTIMATOR, SCHEMAS
from aerial_gnss_ros.preflight.monitor import InputMonitor
from aerial_gnss_ros.text.sentences import counted

INCOMPLETE = 1
_WIDTH = 100
_INSTEAD = {
    "camera_info": "parameters, with focal_length_mm, sensor_width_mm, image_width_px and "
    "image_height_px"
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Status 0: a profile has all its inputs; 1: none has. Profiles are matched by topic "
        "names and types only: check signs and references with `aerial-gnss check` afterwards."
    )
    parser.add_argument(
        "bags", type=Path, nargs="*", metavar="BAG",
        help="recorded bags (default: the live topics)",
    )  # fmt: skip
    parser.add_argument(
        "--seconds", type=float, default=5.0, metavar="S",
        help="duration for live topics, s (%(default)g)",
    )  # fmt: skip
    parser.add_argument(
        "--vehicle", action="append", metavar="NAME|PATH", default=[],
        help="consider only this profile; may be repeated",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print the findings as JSON")


def run(args: argparse.Namespace) -> int:
    """Inspect a bag or the live graph."""
    if not (math.isfinite(args.seconds) and args.seconds > 0.0):
        raise InputError(f"--seconds must be above 0, not {args.seconds:g}.")
    seen = _seen(args)
    names = args.vehicle or vehicle_names()
    profiles = {name: _subscriptions(name) for name in names}
    ranked = fits(profiles, seen)
    best = ranked[0]
    others = other_drones(profiles, seen, best)
    if args.json:
        print(json.dumps(_as_json(seen, ranked, others), indent=2))
    else:
        _print(args.bags, seen, ranked, others)
    return 0 if best.matched and not best.missing else INCOMPLETE


def _seen(args: argparse.Namespace) -> list[SeenTopic]:
    if args.bags:
        with open_bag(args.bags) as bag:
            seen = survey(bag)
        if not seen:
            raise InputError(f"{args.bags[0]} holds no messages at all.")
        return seen
    require_ros()
    from aerial_gnss_ros.nodes.listening import survey as survey_live

    seen = survey_live(args.seconds)
    if not seen:
        raise InputError(
            f"no topic has a publisher (within {args.seconds:g} s): start the vehicle's driver, "
            "and compare ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE on both sides."
        )
    return seen


def _subscriptions(vehicle: str) -> Sequence[Subscription]:
    values = read([vehicle_file(vehicle)], SCHEMAS, "/")
    config = estimator_config({key: _given(value) for key, value in values[ESTIMATOR].items()})
    return Feed(config, InputMonitor(config)).subscriptions


def _given(value: Any) -> Any:
    """Return a value with NaN replaced: the topics of a mast do not depend on its position."""
    if isinstance(value, tuple):
        return tuple(_given(item) for item in value)
    return 1.0 if isinstance(value, float) and math.isnan(value) else value


def _images(vehicle: str, namespace: str, seen: Sequence[SeenTopic]) -> tuple[str, list[SeenTopic]]:
    """Return the profile's image topic if it exists, else empty, and all image topics."""
    topic = detector_config(read([vehicle_file(vehicle)], SCHEMAS, "/")[DETECTOR]).image.topic
    name = topic if topic.startswith("/") else "/" + f"{namespace}/{topic}".strip("/")
    images = [t for t in seen if t.msgtype in IMAGE_TYPES]
    there = [t.name for t in images if t.name in (name, f"{name}/compressed")]
    return (there[0] if there else ""), images


def _print(
    bags: Sequence[Path], seen: Sequence[SeenTopic], ranked: Sequence[Fit], others: Sequence[Fit]
) -> None:
    width = min(48, max(len(t.name) for t in seen))
    print(counted(len(seen), "topic"))
    for topic in seen:
        print(f"  {topic.name:<{width}}  {topic.rate_hz:6.1f} Hz  {topic.msgtype}")
        if topic.trouble:
            print(textwrap.fill(topic.trouble, _WIDTH, initial_indent="    ! ",
                                subsequent_indent="      "))  # fmt: skip
    print("\nprofiles")
    for fit in ranked:
        needed = len(fit.matched) + len(fit.missing)
        where = f", namespace {fit.namespace}" if fit.namespace and fit.matched else ""
        print(f"  {fit.profile:<18} {len(fit.matched)} of {needed} inputs{where}")
    best = ranked[0]
    if not best.matched:
        print(
            "\nNo profile matches. Copy config/vehicles/generic.yaml, enter your topics and "
            "their references, and pass it with --vehicle."
        )
        _print_yaml(best, seen)
        return
    print(f"\nbest: {best.profile}" + (f", namespace {best.namespace}" if best.namespace else ""))
    for name, found in best.matched.items():
        print(f"  {name:<12} {found}")
    for line in _best_troubles(best):
        print(textwrap.fill(f"  ! {line}", _WIDTH, subsequent_indent="    "))
    equals = [
        f.profile for f in ranked[1:] if f.score == best.score and f.namespace == best.namespace
    ]
    if equals:
        print(f"  {' and '.join(equals)} matches equally well: choose the one of your autopilot.")
    for other in others:
        flags = f"--vehicle {other.profile}" + (
            f" --namespace {other.namespace}" if other.namespace else ", no namespace"
        )
        print(f"  another drone: {flags}")
    _print_commands(bags, best)
    _print_yaml(best, seen)


def _best_troubles(best: Fit) -> list[str]:
    lines = []
    for subscription in best.missing:
        wrong = best.wrong_type.get(subscription.name)
        if wrong:
            lines.append(
                f"{subscription.name}: {wrong.name} carries {wrong.msgtype}, not "
                f"{subscription.msgtype}"
            )
        else:
            lines.append(f"{subscription.name}: no topic {subscription.topic}")
    return lines


def _print_commands(bags: Sequence[Path], best: Fit) -> None:
    flags = f"--vehicle {best.profile}"
    words = f"vehicle:={best.profile}"
    if best.namespace:
        flags += f" --namespace {best.namespace}"
        words += f" namespace:={best.namespace}"
    paths = "".join(f" {path}" for path in bags)
    print("\npaste")
    print(f"  aerial-gnss check{paths} {flags}")
    if bags:
        print(f"  aerial-gnss replay{paths} {flags} -o result")
    print(f"  aerial-gnss run {flags}")
    print(f"  ros2 launch aerial_gnss_ros aerial_gnss.launch.py {words}")


def _print_yaml(best: Fit, seen: Sequence[SeenTopic]) -> None:
    """Print parameters for the profile's missing inputs, with all candidate topics."""
    lines = _estimator_lines(best, seen)
    image, images = _images(best.profile, best.namespace, seen)
    detector = []
    if not image and images:
        compressed = images[0].msgtype == IMAGE_TYPES[1]
        topic = images[0].name.removesuffix("/compressed")
        detector = [f"      topic: {topic}"]
        detector += ["      transport: compressed"] if compressed else []
        detector += [f"      # or {other.name}" for other in images[1:]]
    if not lines and not detector:
        return
    print("\nand in a file for --params, after choosing among alternatives")
    if detector:
        print("  /**/detector:\n    ros__parameters:\n      image:")
        print("\n".join("  " + line for line in detector))
    if lines:
        print("  /**/estimator:\n    ros__parameters:")
        print("\n".join(lines))


def _estimator_lines(best: Fit, seen: Sequence[SeenTopic]) -> list[str]:
    lines: list[str] = []
    lacking = {subscription.name for subscription in best.missing}
    for subscription in best.missing:
        if subscription.name == "home":
            if "height" not in lacking:  # otherwise the height may have another source
                lines += ["      height:", "        # home_topic: altitude of the take-off point"]
            continue
        group = {"camera_info": "camera"}.get(subscription.name, subscription.name)
        found = candidates(subscription.name, seen)
        lines.append(f"      {group}:")
        if not found:
            lines.append(f"        # no topic has a message type with {subscription.name}")
            instead = _INSTEAD.get(subscription.name, "constant, with its values")
            lines.append(f"        # source: {instead}, if it never changes")
        for i, (topic, kind) in enumerate(found):
            mark = "" if i == 0 else "# or "
            lines.append(f"        {mark}topic: {topic.name}")
            lines += [f"        {mark}type: {kind}"] if kind else []
    return lines


def _as_json(
    seen: Sequence[SeenTopic], ranked: Sequence[Fit], others: Sequence[Fit]
) -> dict[str, Any]:
    return {
        "topics": [
            {"name": t.name, "type": t.msgtype, "rate_hz": round(t.rate_hz, 3), "count": t.count,
             "trouble": t.trouble}
            for t in seen
        ],
        "profiles": [
            {
                "profile": fit.profile,
                "namespace": fit.namespace,
                "complete": bool(fit.matched) and not fit.missing,
                "matched": dict(fit.matched),
                "wrong_type": {name: topic.name for name, topic in fit.wrong_type.items()},
                "missing": [s.name for s in fit.missing],
            }
            for fit in ranked
        ],
        "other_drones": [{"profile": f.profile, "namespace": f.namespace} for f in others],
    }  # fmt: skip
