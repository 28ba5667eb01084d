# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss stream`: hands live positions on to other programs, by UDP."""

from __future__ import annotations

import argparse
import ipaddress
import math
import sys
from collections import Counter
from typing import Any

from aerial_gnss_ros.adapters.sightings import host_and_port, sighting
from aerial_gnss_ros.commands.udp_outputs import CursorOnTarget, Mavlink, Output
from aerial_gnss_ros.core.errors import InputError
from aerial_gnss_ros.nodes import require_ros

HELP = "send live positions on: Cursor on Target, MAVLink"
COT_DEFAULT, MAVLINK_DEFAULT = "127.0.0.1:4242", "127.0.0.1:14550"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Nothing leaves this computer unless an address says so; what is sent is neither encrypted "
        "nor signed. For files see `aerial-gnss replay`: GPX, GeoJSON, KML."
    )
    parser.add_argument(
        "--cot", nargs="?", const=COT_DEFAULT, metavar="HOST:PORT",
        help="Cursor on Target events by UDP, for TAK programs (%(const)s)",
    )  # fmt: skip
    parser.add_argument(
        "--cot-type", default="a-f-S", metavar="TYPE",
        help="of the events: a-f-S friendly sea surface, a-f-U subsurface (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--stale", type=float, default=30.0, metavar="S",
        help="after so long receivers show a position as outdated (%(default)g)",
    )  # fmt: skip
    parser.add_argument(
        "--mavlink", nargs="?", const=MAVLINK_DEFAULT, metavar="HOST:PORT",
        help="CAMERA_TRACKING_GEO_STATUS by UDP (%(const)s); needs --robot where there are several",
    )  # fmt: skip
    parser.add_argument(
        "--mavlink-system", type=int, default=1, metavar="ID", help="of the drone (%(default)s)"
    )
    parser.add_argument(
        "--robot", metavar="ID", help="only this robot; MAVLink otherwise follows the first one"
    )
    parser.add_argument("--namespace", default="", help="of the estimator, such as drone1")
    parser.add_argument(
        "--seconds", type=float, metavar="S", help="end after so long (default: at a signal)"
    )


def run(args: argparse.Namespace) -> int:
    """Stream until a signal."""
    if args.cot is None and args.mavlink is None:
        raise InputError("nothing to send to; give --cot, --mavlink, or both.")
    for name, value in (("--stale", args.stale), ("--seconds", args.seconds)):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} must be above 0 s, not {value:g}.")
    if not 1 <= args.mavlink_system <= 255:
        raise InputError(f"--mavlink-system must be 1 to 255, not {args.mavlink_system}.")
    require_ros()
    from aerial_gnss_ros.nodes.robots import hear_robots

    cot, mavlink = _cot(args), _mavlink(args)
    outputs = [output for output in (cot, mavlink) if output is not None]
    sent: Counter[str] = Counter()
    followed = [args.robot] if args.robot else []

    def take(robot: str, message: Any) -> None:
        if args.robot and robot != args.robot:
            return
        if not sent[robot]:
            print(f"sending {robot}", file=sys.stderr, flush=True)
        seen = sighting(robot, message)
        sent[robot] += 1
        if cot is not None:
            cot.send(seen)
        if not followed:
            followed.append(robot)
        if mavlink is not None and robot == followed[0]:
            mavlink.send(seen)

    try:
        hear_robots(args.namespace, args.seconds, take)
    finally:
        for output in outputs:
            output.close()
    total = ", ".join(f"{robot} {count}" for robot, count in sorted(sent.items()))
    print(f"sent: {total or 'nothing, no robot was published'}")
    return 0


def _cot(args: argparse.Namespace) -> Output | None:
    if args.cot is None:
        return None
    host, port = _announced(args.cot, "Cursor on Target")
    return CursorOnTarget(host, port, args.cot_type, args.stale)


def _mavlink(args: argparse.Namespace) -> Output | None:
    if args.mavlink is None:
        return None
    host, port = _announced(args.mavlink, "MAVLink")
    return Mavlink(host, port, args.mavlink_system)


def _announced(text: str, what: str) -> tuple[str, int]:
    """Return host and port, and tell where positions leave this computer."""
    host, port = host_and_port(text)
    if not _is_loopback(host):
        print(f"{what}: positions go to {host}, readable for all on the way", file=sys.stderr)
    return host, port


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
