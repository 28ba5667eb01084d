# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Per-robot outputs: GPS_INPUT and NMEA to each robot's address, AIS to a plotter."""

from __future__ import annotations

import importlib
import re
import time
from collections.abc import Callable, Mapping, Sequence
from itertools import count
from typing import Any

from aerial_gnss_ros.adapters.ais import position_report, static_report
from aerial_gnss_ros.adapters.gps_input import gps_input
from aerial_gnss_ros.adapters.nmea import gga, rmc
from aerial_gnss_ros.adapters.sightings import Sighting, host_and_port
from aerial_gnss_ros.adapters.target_absolute import target_absolute
from aerial_gnss_ros.commands.udp_outputs import CAMERA_COMPONENT, Udp, mavlink_dialect
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.resources import install_hint

GPS_COMPONENT = 220  # MAV_COMP_ID_GPS
NAME_S = 60.0
"""Interval of a target's name, s; AIS itself uses 6 minutes."""


def by_robot(pairs: Sequence[str], flag: str, default: str) -> dict[str, tuple[str, int]]:
    """Return addresses by robot of arguments such as `aqua_1=192.168.2.2:14560` and `aqua_1`.

    Raises:
        InputError: an argument has another form, or a robot has two addresses.
    """
    found: dict[str, tuple[str, int]] = {}
    for pair in pairs:
        robot, _, address = pair.partition("=")
        if not robot or robot in found:
            raise InputError(f"{flag} {pair}: give each robot once, as ROBOT or ROBOT=HOST:PORT.")
        found[robot] = host_and_port(address or default)
    return found


def mmsis(pairs: Sequence[str]) -> dict[str, int]:
    """Return MMSIs by robot of arguments such as `aqua_1=211234567`.

    Raises:
        InputError: an MMSI is not nine digits.
    """
    found = {}
    for pair in pairs:
        robot, _, digits = pair.partition("=")
        if not robot or not re.fullmatch(r"[0-9]{9}", digits):
            raise InputError(f"--mmsi {pair}: give ROBOT=MMSI with nine digits that are assigned.")
        found[robot] = int(digits)
    return found


class Fresh:
    """Passes positions that are really new, at a limited rate.

    A robot's first position may have been latched long ago, but receivers of these formats take
    every position as current.

    Args:
        rate_hz: greatest rate by the stamps, Hz.
    """

    def __init__(self, rate_hz: float) -> None:
        self._step_ns = round(1e9 / rate_hz)
        self._newest: dict[str, int] = {}
        self._sent: dict[str, int] = {}

    def passes(self, seen: Sighting) -> bool:
        """Return whether to send a position."""
        robot, stamp_ns = seen.robot_id, seen.stamp_ns
        newest_ns = self._newest.get(robot)
        self._newest[robot] = stamp_ns
        if newest_ns is None or stamp_ns <= newest_ns:
            return False
        last_ns = self._sent.get(robot)
        # Tolerates a tenth of a step: images arrive with jitter.
        if last_ns is not None and 0 <= stamp_ns - last_ns < 0.9 * self._step_ns:
            return False
        self._sent[robot] = stamp_ns
        return True


class ToRobots:
    """Sends each robot's own position to its own address.

    Args:
        name: of the format, for messages.
        addresses: by robot; others are not sent.
        encode: encodes a position as a datagram; None: nothing is sent.
        rate_hz: greatest rate, Hz.

    Raises:
        InputError: a host is unknown.
    """

    def __init__(
        self,
        name: str,
        addresses: Mapping[str, tuple[str, int]],
        encode: Callable[[Sighting], bytes | None],
        rate_hz: float,
    ) -> None:
        self.name = name
        self._udp = {robot: Udp(*address) for robot, address in addresses.items()}
        self._encode, self._fresh = encode, Fresh(rate_hz)

    @property
    def leaving(self) -> list[str]:
        """Robots whose positions leave this computer."""
        return [robot for robot, udp in self._udp.items() if udp.leaves]

    def send(self, seen: Sighting) -> bool:
        """Send a position; return whether it was sent."""
        udp = self._udp.get(seen.robot_id)
        if udp is None or not self._fresh.passes(seen):
            return False
        data = self._encode(seen)
        if data is not None:
            udp.write(data)
        return data is not None

    def close(self) -> None:
        """Close the sockets."""
        for udp in self._udp.values():
            udp.close()


def nmea_datagram(seen: Sighting) -> bytes:
    """Return GGA and RMC in one datagram."""
    return (gga(seen) + rmc(seen)).encode("ascii")


def gps_input_encoder(system: int, satellites: int) -> Callable[[Sighting], bytes | None]:
    """Return an encoder of GPS_INPUT messages; a robot out of view gives none.

    Raises:
        InputError: pymavlink is not installed.
    """
    mavlink = mavlink_dialect().MAVLink(None, srcSystem=system, srcComponent=GPS_COMPONENT)

    def encode(seen: Sighting) -> bytes | None:
        if not seen.measured:
            return None
        message = mavlink.gps_input_encode(**gps_input(seen, satellites))
        data = bytes(message.pack(mavlink))
        mavlink.seq = (mavlink.seq + 1) % 256
        return data

    return encode


def target_absolute_encoder(
    system: int, robots: Sequence[str]
) -> Callable[[Sighting], bytes | None]:
    """Return an encoder of TARGET_ABSOLUTE messages; a robot out of view gives none.

    Args:
        system: MAVLink system id of the drone.
        robots: in the order of their numbers as targets.
    """
    numbers, frames = {robot: number for number, robot in enumerate(robots)}, count()

    def encode(seen: Sighting) -> bytes | None:
        if not seen.measured:
            return None
        target, seq = numbers[seen.robot_id], next(frames) % 256
        return target_absolute(seen, target, system, CAMERA_COMPONENT, seq)

    return encode


class Ais:
    """Shows robots with an MMSI on a plotter, as class B targets (AIVDM by UDP).

    Args:
        address: host and port of the plotter.
        numbers: MMSI by robot; robots without one are not sent.
        rate_hz: greatest rate, Hz.
        clock: monotonic seconds.

    Raises:
        InputError: the host is unknown, or pyais is not installed.
    """

    name = "AIS"

    def __init__(
        self,
        address: tuple[str, int],
        numbers: Mapping[str, int],
        rate_hz: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        try:
            self._encode: Any = importlib.import_module("pyais").encode_dict
        except ImportError as error:
            raise InputError(
                f"AIS output needs pyais; install it with {install_hint('ais')}."
            ) from error
        self._udp, self._numbers, self._clock = Udp(*address), dict(numbers), clock
        self._fresh = Fresh(rate_hz)
        self._named: dict[str, float] = {}

    @property
    def leaving(self) -> list[str]:
        """Robots whose positions leave this computer."""
        return list(self._numbers) if self._udp.leaves else []

    def send(self, seen: Sighting) -> bool:
        """Send a position, and periodically the name; return whether it was sent."""
        mmsi = self._numbers.get(seen.robot_id)
        if mmsi is None or not self._fresh.passes(seen):
            return False
        self._write(position_report(seen, mmsi))
        now_s = self._clock()
        if now_s - self._named.get(seen.robot_id, -NAME_S) >= NAME_S:
            self._named[seen.robot_id] = now_s
            self._write(static_report(seen, mmsi))
        return True

    def _write(self, fields: dict[str, Any]) -> None:
        for sentence in self._encode(fields, talker_id="AI", sentence_type="VDM"):
            self._udp.write(f"{sentence}\r\n".encode("ascii"))

    def close(self) -> None:
        """Close the socket."""
        self._udp.close()
