# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Stamps and headers of messages, by attribute, of rclpy and of rosbags."""

from __future__ import annotations

from typing import Any

SECOND_NS = 1_000_000_000


def nanoseconds(stamp: Any) -> int:
    """Return a builtin_interfaces/Time as integer nanoseconds."""
    return int(stamp.sec) * SECOND_NS + int(stamp.nanosec)


def stamp_fields(stamp_ns: int) -> dict[str, int]:
    """Return the fields of a builtin_interfaces/Time."""
    sec, nanosec = divmod(stamp_ns, SECOND_NS)
    return {"sec": sec, "nanosec": nanosec}


def header_fields(stamp_ns: int, frame_id: str) -> dict[str, Any]:
    """Return the fields of a std_msgs/Header."""
    return {"stamp": stamp_fields(stamp_ns), "frame_id": frame_id}


def copied_header(header: Any) -> dict[str, Any]:
    """Return the fields of a copy of another message's header."""
    return header_fields(nanoseconds(header.stamp), str(header.frame_id))
