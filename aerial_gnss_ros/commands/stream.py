# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss stream`: sends live positions to other programs by UDP."""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter
from collections.abc import Sequence
from typing import Any

from aerial_gnss_ros.adapters.sightings import Sighting, host_and_port, sighting
from aerial_gnss_ros.commands.robot_outputs import (
    Ais,
    ToRobots,
    by_robot,
    gps_input_encoder,
    mmsis,
    nmea_datagram,
    target_absolute_encoder,
)
from aerial_gnss_ros.commands.udp_outputs import CursorOnTarget, Mavlink, Output
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.nodes import require_ros
from aerial_gnss_ros.text.sentences import counted, shown

_LONGEST_S = 10_000_000.0
_FASTEST_HZ = 100.0
_TYPE = re.compile(r"[A-Za-z0-9]+(-[A-Za-z0-9]+)*")
COT_DEFAULT, MAVLINK_DEFAULT = "127.0.0.1:4242", "127.0.0.1:14550"
MOST_TARGETS = 256  # TARGET_ABSOLUTE numbers them in a byte
GPS_DEFAULT, NMEA_DEFAULT, AIS_DEFAULT = "127.0.0.1:14560", "127.0.0.1:10110", "127.0.0.1:10111"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Nothing leaves this computer unless you give another address; messages are neither "
        "encrypted nor signed. For files see `aerial-gnss replay`: GPX, GeoJSON, KML."
    )
    parser.add_argument(
        "--cot", nargs="?", const=COT_DEFAULT, metavar="HOST:PORT",
        help="Cursor on Target events by UDP, for TAK programs (%(const)s)",
    )  # fmt: skip
    parser.add_argument(
        "--cot-type", default="a-f-S", metavar="TYPE",
        help="type of the events: a-f-S friendly sea surface, a-f-U subsurface (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--stale", type=float, default=30.0, metavar="S",
        help="time after which receivers show a position as outdated, s (%(default)g)",
    )  # fmt: skip
    parser.add_argument(
        "--mavlink", nargs="?", const=MAVLINK_DEFAULT, metavar="HOST:PORT",
        help="CAMERA_TRACKING_GEO_STATUS by UDP (%(const)s), of one robot: see --robot",
    )  # fmt: skip
    parser.add_argument(
        "--mavlink-system",
        type=int,
        default=1,
        metavar="ID",
        help="MAVLink system id of the drone (%(default)s)",
    )
    _add_robot_arguments(parser)
    parser.add_argument(
        "--robot",
        metavar="ID",
        help="send only this robot; MAVLink otherwise follows the first one",
    )
    parser.add_argument(
        "--namespace", default="", help="namespace of the estimator, such as drone1"
    )
    parser.add_argument(
        "--seconds", type=float, metavar="S", help="duration, s (default: until a signal)"
    )


def _add_robot_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the per-robot outputs and the plotter's."""
    parser.add_argument(
        "--gps-input", action="append", default=[], metavar="ROBOT[=HOST:PORT]",
        help=
                f"MAVLink GPS_INPUT by UDP, to that robot's autopilot ({GPS_DEFAULT}); may be "
                "repeated",
    )  # fmt: skip
    parser.add_argument(
        "--target-absolute", action="append", default=[], metavar="ROBOT[=HOST:PORT]",
        help=
                f"MAVLink TARGET_ABSOLUTE by UDP, for a vehicle that follows the robot "
                f"({MAVLINK_DEFAULT}); may be repeated, the first one is target 0",
    )  # fmt: skip
    parser.add_argument(
        "--satellites", type=int, default=10, metavar="N",
        help=
                "number of satellites in GPS_INPUT, which has no value for unknown; autopilots "
                "require 6 (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--nmea", action="append", default=[], metavar="ROBOT[=HOST:PORT]",
        help=f"NMEA 0183 GGA and RMC by UDP ({NMEA_DEFAULT}); may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--ais", nargs="?", const=AIS_DEFAULT, metavar="HOST:PORT",
        help="AIS class B targets by UDP, to a plotter only, never on the air (%(const)s)",
    )  # fmt: skip
    parser.add_argument(
        "--mmsi", action="append", default=[], metavar="ROBOT=MMSI",
        help="MMSI assigned to a robot; robots without one are not sent",
    )  # fmt: skip
    parser.add_argument(
        "--rate", type=float, default=5.0, metavar="HZ",
        help="greatest rate of GPS_INPUT, TARGET_ABSOLUTE, NMEA and AIS, Hz (%(default)g)",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Stream until a signal."""
    if args.cot is None and args.mavlink is None and not _robot_outputs_wanted(args):
        raise InputError(
            "no output; give --cot, --mavlink, --gps-input, --target-absolute, --nmea or --ais."
        )
    if not 0.0 < args.rate <= _FASTEST_HZ:
        raise InputError(f"--rate must be above 0 and at most {_FASTEST_HZ:g}, not {args.rate:g}.")
    if not 0 <= args.satellites <= 254:
        raise InputError(f"--satellites must be 0 to 254, not {args.satellites}.")
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
    own = _robot_outputs(args)
    outputs = [*(output for output in (cot, mavlink) if output is not None), *own]
    stream = Stream(cot, mavlink, args.robot, own)

    def receive(robot: str, message: Any) -> None:
        try:
            seen = sighting(robot, message, args.namespace)
        except InputError as error:
            stream.refuse(str(error))
        else:
            stream.send(seen)

    try:
        hear_robots(args.namespace, args.seconds, receive)
    finally:
        for output in outputs:
            output.close()
    total = ", ".join(f"{robot} {count}" for robot, count in sorted(stream.sent.items()))
    print(f"sent: {total or 'nothing, no robot was published'}")
    if stream.refused:
        print(f"not sent: {counted(stream.refused, 'message')}; the first: {stream.why}")
    return 0


class Stream:
    """Sends positions to the outputs, and reports each robot's destination once.

    Args:
        cot: output of every robot, or None.
        mavlink: output of one robot, because its message has no robot's name; or None.
        only: the robot to send; None: all, by MAVLink the first one received.
        own: outputs with their own choice of robots.

    Attributes:
        sent: positions sent, by robot.
        refused: number of messages without a position.
        why: the error of the first of them.
    """

    def __init__(
        self,
        cot: Output | None,
        mavlink: Output | None,
        only: str | None,
        own: Sequence[ToRobots | Ais] = (),
    ) -> None:
        self._own = own
        self._cot, self._mavlink, self._only = cot, mavlink, only
        self._followed = only
        self._told: set[str] = set()
        self._said: set[str] = set()  # robots already reported as sent
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
        taken = [output.send(seen) for output in self._own]
        if any(taken) and self._first_of(robot):
            print(f"sending {robot}", file=sys.stderr, flush=True)
        self.sent[robot] += bool(self._cot is not None or follows or any(taken))

    def _first_of(self, robot: str) -> bool:
        """Return whether a robot has not yet been reported as sent."""
        first = robot not in self._said
        self._said.add(robot)
        return first

    def _tell(self, robot: str, follows: bool) -> None:
        if self._cot is not None or follows:
            self._said.add(robot)
            print(f"sending {robot}", file=sys.stderr, flush=True)
        if self._mavlink is not None and not follows:
            print(
                f"MAVLink follows one robot, {self._followed}: {robot} is not sent there; choose "
                f"it with --robot {robot}",
                file=sys.stderr, flush=True,
            )  # fmt: skip


def _robot_outputs_wanted(args: argparse.Namespace) -> bool:
    return bool(args.gps_input or args.target_absolute or args.nmea or args.ais is not None)


def _robot_outputs(args: argparse.Namespace) -> list[ToRobots | Ais]:
    """Return the outputs with their own choice of robots."""
    gps = by_robot(args.gps_input, "--gps-input", GPS_DEFAULT)
    targets = by_robot(args.target_absolute, "--target-absolute", MAVLINK_DEFAULT)
    if len(targets) > MOST_TARGETS:
        raise InputError(
            f"--target-absolute can be given {MOST_TARGETS} times, not {len(targets)}."
        )
    nmea = by_robot(args.nmea, "--nmea", NMEA_DEFAULT)
    numbers = mmsis(args.mmsi)
    if args.ais is not None and not numbers:
        raise InputError("--ais needs --mmsi ROBOT=MMSI: an MMSI is assigned, never invented.")
    found: list[ToRobots | Ais] = []
    if gps:
        encode = gps_input_encoder(args.mavlink_system, args.satellites)
        found.append(ToRobots("GPS_INPUT", gps, encode, args.rate))
    if targets:
        follow = target_absolute_encoder(args.mavlink_system, list(targets))
        found.append(ToRobots("TARGET_ABSOLUTE", targets, follow, args.rate))
    if nmea:
        found.append(ToRobots("NMEA", nmea, nmea_datagram, args.rate))
    if args.ais is not None:
        found.append(Ais(host_and_port(args.ais), numbers, args.rate))
    for output in found:
        if output.leaving:
            print(
                f"{output.name}: positions of {', '.join(output.leaving)} leave this computer, "
                "unencrypted", file=sys.stderr,
            )  # fmt: skip
    return found


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
    """Report destinations outside this computer, whatever their host names."""
    if output.leaves:
        print(f"{what}: positions go to {host}, unencrypted", file=sys.stderr)
