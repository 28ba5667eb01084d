# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sends published positions by UDP: Cursor on Target, and MAVLink through pymavlink."""

from __future__ import annotations

import importlib
import ipaddress
import os
import socket
from typing import Any, Protocol

from aerial_gnss_ros.adapters.sightings import Sighting, cursor_on_target, tracking_geo_status
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.resources import install_hint

CAMERA_COMPONENT = 100  # MAV_COMP_ID_CAMERA


class Output(Protocol):
    """An output for published positions."""

    def send(self, seen: Sighting) -> None:
        """Send one position."""

    def close(self) -> None:
        """End."""


class Udp:
    """Sends datagrams to one address.

    Datagrams to this computer are sent from its loopback address: an unbound socket would also
    accept datagrams from the network.
    """

    def __init__(self, host: str, port: int) -> None:
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        except OSError as error:
            raise InputError(f"{host} cannot be resolved ({error}).") from error
        self._address: Any = found[4]
        self._socket = socket.socket(found[0], found[1])
        self._socket.setblocking(False)
        if not self.leaves:
            self._socket.bind((self._address[0], 0))
        self.lost = 0

    @property
    def leaves(self) -> bool:
        """Whether datagrams leave this computer."""
        return not ipaddress.ip_address(self._address[0].partition("%")[0]).is_loopback

    def write(self, data: bytes) -> None:
        """Send a datagram; a failure is counted."""
        try:
            self._socket.sendto(data, self._address)
        except OSError:  # no route or a full buffer: the next position follows soon
            self.lost += 1

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


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
