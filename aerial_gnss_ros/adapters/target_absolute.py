# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A published position as MAVLink TARGET_ABSOLUTE (510), a moving target to follow.

The message is work in progress in MAVLink's development.xml, and released pymavlink lacks it: the
frame is written here, after https://mavlink.io/en/guide/serialization.html.
"""

from __future__ import annotations

import math
import struct

from aerial_gnss_ros.adapters.sightings import Sighting
from aerial_gnss_ros.core.geometry.geoid import undulation

ID, CRC_EXTRA = 510, 245
POSITION = 1  # TARGET_ABSOLUTE_SENSOR_CAPABILITY_FLAGS
START = 0xFD
VERTICAL_M = 5.0
"""One sigma of a known altitude: that of the drone's receiver."""

_PAYLOAD = struct.Struct("<Qii22f2B")
_UNKNOWN = math.nan


def target_absolute(seen: Sighting, target: int, system: int, component: int, seq: int) -> bytes:
    """Return a MAVLink 2 frame.

    Altitude is above mean sea level by EGM96, NaN if unknown; so are velocity, acceleration,
    orientation and rates, which the capabilities leave out.

    Args:
        seen: a measured position; the message cannot say that a robot is coasting.
        target: number of the robot, 0 to 255.
        system: sender's system id.
        component: sender's component id.
        seq: number of the frame, 0 to 255.
    """
    known = math.isfinite(seen.altitude)
    altitude = seen.altitude - undulation(seen.latitude, seen.longitude) if known else _UNKNOWN
    motion = 13 * [_UNKNOWN]  # velocity 3, acceleration 3, quaternion 4, rates 3
    errors = [math.sqrt(2.0) * seen.sigma, VERTICAL_M if known else _UNKNOWN, *6 * [_UNKNOWN]]
    payload = _PAYLOAD.pack(
        seen.stamp_ns // 1000,
        round(math.degrees(seen.latitude) * 1e7),
        round(math.degrees(seen.longitude) * 1e7),
        altitude,
        *motion,
        *errors,
        target,
        POSITION,
    )
    head = bytes([len(payload), 0, 0, seq, system, component]) + ID.to_bytes(3, "little")
    crc = _crc(head + payload + bytes([CRC_EXTRA]))
    return bytes([START]) + head + payload + crc.to_bytes(2, "little")


def _crc(data: bytes) -> int:
    """Return the checksum CRC-16/MCRF4XX that MAVLink uses."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ 0x8408 if crc & 1 else crc >> 1
    return crc
