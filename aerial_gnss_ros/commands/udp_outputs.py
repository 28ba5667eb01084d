# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sends published positions by UDP: Cursor on Target, and MAVLink through pymavlink."""

from __future__ import annotations

import importlib
import ipaddress
import os
import socket
import sys
import time
from typing import Any, Protocol, cast

from aerial_gnss_ros.adapters.sightings import Sighting, cursor_on_target, tracking_geo_status
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.resources import install_hint

CAMERA_COMPONENT = 100  # MAV_COMP_ID_CAMERA
REACHED_S = 5.0
"""Time without a refusal after which somebody listens again; hosts refuse about once a second."""


class Output(Protocol):
    """An output for published positions."""

    def send(self, seen: Sighting) -> None:
        """Send one position."""

    def close(self) -> None:
        """End."""


class Udp:
    """Sends datagrams to one address.

    The socket is connected, so that it accepts datagrams from no other address and learns that
    nobody listens. That, or a network that is down, is said once; sending goes on.

    Args:
        host: name or address of the receiver.
        port: its UDP port.

    Attributes:
        lost: datagrams that could not be sent.

    Raises:
        InputError: the host is unknown.
    """

    def __init__(self, host: str, port: int) -> None:
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        except OSError as error:
            raise InputError(f"{host} cannot be resolved ({error}).") from error
        self._family, self._address = found[0], cast("Any", found[4])
        self._name = f"{host}:{port}"
        self._socket: socket.socket | None = None
        self._failed_s: float | None = None  # last time, until it is reached again
        self.lost = 0

    @property
    def leaves(self) -> bool:
        """Whether datagrams leave this computer."""
        return not ipaddress.ip_address(self._address[0].partition("%")[0]).is_loopback

    def write(self, data: bytes) -> None:
        """Send a datagram; a failure is counted, and the first of several is reported."""
        try:
            if self._socket is None:
                self._socket = self._connected()
            try:
                self._socket.send(data)
            except ConnectionRefusedError:  # by an earlier datagram; this one was not sent
                self._report("nobody listens there (connection refused)")
                self._socket.send(data)
                return
        except BlockingIOError:  # a full buffer: the next position follows soon
            self.lost += 1
        except OSError as error:
            self.lost += 1
            self._report(error.strerror or str(error))
            self.close()  # the next one begins anew: this computer's address may have changed
        else:
            self._receives()

    def _connected(self) -> socket.socket:
        made = socket.socket(self._family, socket.SOCK_DGRAM)
        try:
            made.setblocking(False)
            made.connect(self._address)
        except OSError:
            made.close()
            raise
        return made

    def _report(self, why: str) -> None:
        first, self._failed_s = self._failed_s is None, time.monotonic()
        if first:
            print(
                f"{self._name}: {why}; positions are still sent there",
                file=sys.stderr, flush=True,
            )  # fmt: skip

    def _receives(self) -> None:
        """Report that an address is reached again, some time after the last refusal."""
        if self._failed_s is not None and time.monotonic() - self._failed_s >= REACHED_S:
            self._failed_s = None
            print(f"{self._name}: reached again", file=sys.stderr, flush=True)

    def close(self) -> None:
        """Close the socket."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def mavlink_dialect() -> Any:
    """Return pymavlink's module of the messages in common.xml.

    Raises:
        InputError: pymavlink is not installed.
    """
    os.environ["MAVLINK20"] = "1"  # message numbers above 255 need version 2
    try:
        return importlib.import_module("pymavlink.dialects.v20.common")
    except ImportError as error:
        raise InputError(
            f"MAVLink output needs pymavlink; install it with {install_hint('mavlink')}."
        ) from error


class CursorOnTarget:
    """Sends each position as a Cursor on Target event.

    Args:
        host: receiver.
        port: its UDP port.
        kind: the events' type.
        stale_s: see `adapters.sightings.cursor_on_target`.

    Raises:
        InputError: the host is unknown.
    """

    def __init__(self, host: str, port: int, kind: str, stale_s: float) -> None:
        self._udp = Udp(host, port)
        self._kind, self._stale_s = kind, stale_s

    def send(self, seen: Sighting) -> None:
        """Send one position."""
        self._udp.write(cursor_on_target(seen, self._kind, self._stale_s))

    def close(self) -> None:
        """Close the socket."""
        self._udp.close()

    @property
    def leaves(self) -> bool:
        """Whether positions leave this computer."""
        return self._udp.leaves


class Mavlink:
    """Sends each position as CAMERA_TRACKING_GEO_STATUS, which names one target.

    Args:
        host: receiver, such as a ground station.
        port: its UDP port.
        system: MAVLink system id of the drone.

    Raises:
        InputError: the host is unknown, or pymavlink is not installed.
    """

    def __init__(self, host: str, port: int, system: int) -> None:
        dialect = mavlink_dialect()
        self._udp = Udp(host, port)
        self._mavlink = dialect.MAVLink(self._udp, srcSystem=system, srcComponent=CAMERA_COMPONENT)

    def send(self, seen: Sighting) -> None:
        """Send one position."""
        self._mavlink.camera_tracking_geo_status_send(**tracking_geo_status(seen))

    def close(self) -> None:
        """Close the socket."""
        self._udp.close()

    @property
    def leaves(self) -> bool:
        """Whether positions leave this computer."""
        return self._udp.leaves
