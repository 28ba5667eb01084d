# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss stream`: sends live positions to other programs by UDP."""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter
from typing import Any

from aerial_gnss_ros.adapters.sightings import Sighting, host_and_port, sighting
from aerial_gnss_ros.commands.udp_outputs import CursorOnTarget, Mavlink, Output
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.nodes import require_ros
from aerial_gnss_ros.text.sentences import counted, shown

_LONGEST_S = 10_000_000.0
_TYPE = re.compile(r"[A-Za-z0-9]+(-[A-Za-z0-9]+)*")
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
        help="CAMERA_TRACKING_GEO_STATUS by UDP (%(const)s), of one robot: see --robot",
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
        if value is not None and not 0.0 < value <= _LONGEST_S:
            raise InputError(
                f"{name} must be above 0 s and at most {_LONGEST_S:.0f}, not {value:g}."
            )
    if not _TYPE.fullmatch(args.cot_type):
        raise InputError(
            f"--cot-type must be letters and digits with hyphens, such as a-f-S, not "
            f"{shown(args.cot_type)}."
        )
    if not 1 <= args.mavlink_system <= 255:
        raise InputError(f"--mavlink-system must be 1 to 255, not {args.mavlink_system}.")
    require_ros()
    from aerial_gnss_ros.nodes.robots import hear_robots

    cot, mavlink = _cot(args), _mavlink(args)
    outputs = [output for output in (cot, mavlink) if output is not None]
    stream = Stream(cot, mavlink, args.robot)

    def take(robot: str, message: Any) -> None:
        try:
            seen = sighting(robot, message, args.namespace)
        except InputError as error:
            stream.refuse(str(error))
        else:
            stream.send(seen)

    try:
        hear_robots(args.namespace, args.seconds, take)
    finally:
        for output in outputs:
            output.close()
    total = ", ".join(f"{robot} {count}" for robot, count in sorted(stream.sent.items()))
    print(f"sent: {total or 'nothing, no robot was published'}")
    if stream.refused:
        print(f"not sent: {counted(stream.refused, 'message')}, the first: {stream.why}")
    return 0


class Stream:
    """Sends positions to the outputs, and says once which robot goes where.

    Args:
        cot: takes every robot; None: no such output.
        mavlink: takes one robot, for its message names none; None: no such output.
        only: the robot to send; None: all, and of MAVLink the first one received.

    Attributes:
        sent: positions sent, by robot.
        refused: messages that held no position.
        why: what was wrong with the first of them.
    """

    def __init__(self, cot: Output | None, mavlink: Output | None, only: str | None) -> None:
        self._cot, self._mavlink, self._only = cot, mavlink, only
        self._followed = only
        self._told: set[str] = set()
        self.sent: Counter[str] = Counter()
        self.refused, self.why = 0, ""

    def refuse(self, why: str) -> None:
        """Count a message without a position, and report the first one."""
        if not self.refused:
            self.why = why
            print(f"not sent: {why}", file=sys.stderr, flush=True)
        self.refused += 1

    def send(self, seen: Sighting) -> None:
        """Send one position."""
        robot = seen.robot_id
        if self._only is not None and robot != self._only:
            return
        self._followed = self._followed or robot
        follows = self._mavlink is not None and robot == self._followed
        if robot not in self._told:
            self._told.add(robot)
            self._tell(robot, follows)
        if self._cot is not None:
            self._cot.send(seen)
        if self._mavlink is not None and follows:
            self._mavlink.send(seen)
        self.sent[robot] += bool(self._cot is not None or follows)

    def _tell(self, robot: str, follows: bool) -> None:
        if self._cot is not None or follows:
            print(f"sending {robot}", file=sys.stderr, flush=True)
        if self._mavlink is not None and not follows:
            print(
                f"MAVLink's message names one robot, which is {self._followed}: {robot} is not "
                f"sent there; choose with --robot {robot}",
                file=sys.stderr, flush=True,
            )  # fmt: skip


def _cot(args: argparse.Namespace) -> Output | None:
    if args.cot is None:
        return None
    host, port = host_and_port(args.cot)
    output = CursorOnTarget(host, port, args.cot_type, args.stale)
    _announce(output, host, "Cursor on Target")
    return output


def _mavlink(args: argparse.Namespace) -> Output | None:
    if args.mavlink is None:
        return None
    host, port = host_and_port(args.mavlink)
    output = Mavlink(host, port, args.mavlink_system)
    _announce(output, host, "MAVLink")
    return output


def _announce(output: CursorOnTarget | Mavlink, host: str, what: str) -> None:
    """Say where positions leave this computer, whatever name stands for the address."""
    if output.leaves:
        print(f"{what}: positions go to {host}, readable for all on the way", file=sys.stderr)
