# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters of several drones together: what each tells, and of the node that joins them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from aerial_gnss_ros.core.config.processing import MapConfig, UpdatesConfig
from aerial_gnss_ros.core.config.schema import build, flatten, group, key
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.text.sentences import shown

_NAME = re.compile(r"[a-z]([a-z0-9]|_(?!_|$)){0,63}")


@dataclass(frozen=True)
class SightingsConfig:
    """What the drone tells a fleet: boxes and camera poses, from which the node fleet joins all."""

    drone: str = key(
        "",
        "Name of this drone in a fleet, such as drone1; no two drones have the same. With it, the "
        "topic sightings is published while somebody subscribes. Empty: it is not.",
    )


@dataclass(frozen=True)
class FleetConfig:
    """All parameters of the node fleet."""

    drones: tuple[str, ...] = key(
        (),
        "Namespaces of the drones' estimators, such as drone1, relative to that of this node. Each "
        "needs sightings.drone.",
    )
    gnss_share: float = key(
        0.5,
        "Prior share of the receivers' variance that is common to all: same satellites, same "
        "ionosphere. Too small, and positions seem more precise than they are.",
        low=0.0,
        high=1.0,
    )
    map: MapConfig = group(MapConfig)
    updates: UpdatesConfig = group(UpdatesConfig)


def check_drone(name: str) -> None:
    """Refuse a drone's name that cannot be part of a topic.

    Raises:
        ConfigError: says what is allowed.
    """
    if name and not _NAME.fullmatch(name):
        raise ConfigError(
            f"sightings.drone {shown(name)} cannot be a drone's name: use a-z, 0-9 and single _, a "
            "letter first, at most 64 characters."
        )


def fleet_config(values: Mapping[str, Any]) -> FleetConfig:
    """Return the fleet's parameters from nested or dotted values.

    Raises:
        ConfigError: unknown key, wrong type, out of range, no drones, or one given twice.
    """
    config = build(FleetConfig, flatten(values))
    names = [one.strip("/") for one in config.drones]
    if not all(names):
        raise ConfigError("drones must be namespaces, such as [drone1, drone2].")
    if len(set(names)) < len(names):
        raise ConfigError(f"drones has one namespace twice: {', '.join(names)}.")
    return config
