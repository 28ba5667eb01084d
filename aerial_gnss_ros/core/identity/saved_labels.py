# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labels kept over a restart, and their JSON format."""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass, field
from typing import Any

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.text.json_text import parse_json
from aerial_gnss_ros.text.sentences import shown

VERSION = 1
_NAME = re.compile(r"[a-z][a-z0-9_]*")


@dataclass(frozen=True)
class SavedRobot:
    """Where a labelled robot was last seen.

    Attributes:
        name: the robot's id in topics.
        class_id: class name as the detector gave it.
        latitude: rad, WGS84.
        longitude: rad, WGS84.
        last_seen_ns: stamp of the image that measured it last, ns.
        sigma_m: one sigma of the position, the larger axis, at that time.
    """

    name: str
    class_id: str
    latitude: float
    longitude: float
    last_seen_ns: int
    sigma_m: float


@dataclass(frozen=True)
class SavedNames:
    """All labels issued so far.

    Attributes:
        robots: every labelled robot, including lost ones.
        numbers: last number given, by reduced class name.
    """

    robots: tuple[SavedRobot, ...] = ()
    numbers: dict[str, int] = field(default_factory=dict)


def to_text(saved: SavedNames) -> str:
    """Return labels as JSON, in degrees and metres."""
    robots = {
        robot.name: {
            "class": robot.class_id,
            "latitude_deg": round(math.degrees(robot.latitude), 10),
            "longitude_deg": round(math.degrees(robot.longitude), 10),
            "last_seen_ns": robot.last_seen_ns,
            "sigma_m": round(robot.sigma_m, 4),
        }
        for robot in sorted(saved.robots, key=lambda robot: robot.name)
    }
    document = {"version": VERSION, "numbers": saved.numbers, "robots": robots}
    return json.dumps(document, indent=2, sort_keys=True) + "\n"


def from_text(text: str, source: str) -> SavedNames:
    """Parse the labels of a state file.

    Args:
        text: what `to_text` wrote.
        source: the file's name, for the error.

    Raises:
        ConfigError: the text is incomplete, or was not written by this program.
    """
    try:
        document = parse_json(text)
        if document["version"] != VERSION:
            raise ConfigError(
                f"state_file {source} has version {shown(document['version'])}, this program reads "
                f"{VERSION}; delete it, or name another file."
            )
        numbers = {str(token): int(number) for token, number in document["numbers"].items()}
        robots = tuple(_robot(name, entry) for name, entry in document["robots"].items())
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        raise ConfigError(
            f"state_file {source} is damaged ({type(error).__name__}: {str(error)[:200]}); delete "
            "it to start with new labels, or restore a good copy."
        ) from error
    return SavedNames(robots, numbers)


def _robot(name: str, entry: dict[str, Any]) -> SavedRobot:
    robot = SavedRobot(
        name,
        str(entry["class"]),
        math.radians(entry["latitude_deg"]),
        math.radians(entry["longitude_deg"]),
        int(entry["last_seen_ns"]),
        float(entry["sigma_m"]),
    )
    numbers = (robot.latitude, robot.longitude, robot.sigma_m)
    if not _NAME.fullmatch(name) or abs(robot.last_seen_ns) >= 1 << 63:
        raise ValueError(f"{shown(name)} is not a valid label, or its time is out of range")
    on_earth = abs(robot.latitude) <= math.pi / 2 and abs(robot.longitude) <= math.pi
    if not all(map(math.isfinite, numbers)) or robot.sigma_m <= 0.0 or not on_earth:
        raise ValueError(f"{name[:60]} has {shown(entry)}")
    return robot
