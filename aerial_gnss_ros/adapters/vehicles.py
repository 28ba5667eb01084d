# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Finds vehicle profiles: the shipped ones by name, a user's own by path."""

from __future__ import annotations

from pathlib import Path

from aerial_gnss_ros.adapters.text_files import read_text
from aerial_gnss_ros.adapters.yaml_files import MOST_BYTES
from aerial_gnss_ros.core.values.errors import ConfigError, InputError
from aerial_gnss_ros.core.values.paths import typed_path
from aerial_gnss_ros.resources import config_path

_FOLDER = "vehicles"


def vehicle_file(vehicle: str) -> Path:
    """Return the parameter file of a vehicle.

    Args:
        vehicle: the name of a shipped profile (`generic`), or the path of a YAML file.

    Raises:
        ConfigError: no such profile.
    """
    path = typed_path(vehicle)
    if path.suffix in (".yaml", ".yml") or path.name != vehicle:
        if not path.is_file():
            raise ConfigError(f"vehicle profile {vehicle} does not exist; give a YAML file.")
        return path
    try:
        return config_path(f"{_FOLDER}/{vehicle}.yaml")
    except InputError as error:
        raise ConfigError(
            f"{vehicle} is not a vehicle profile; choose from {', '.join(vehicle_names())}, or "
            "give the path of your own YAML file."
        ) from error


def vehicle_text(vehicle: str) -> str:
    """Return the text of a profile.

    Raises:
        ConfigError: no such profile.
        InputError: the file is not text.
    """
    return read_text(vehicle_file(vehicle), MOST_BYTES)


def vehicle_names() -> list[str]:
    """Return the names of the shipped profiles."""
    return sorted(path.stem for path in config_path(_FOLDER).glob("*.yaml"))


def vehicle_summary(vehicle: str) -> str:
    """Return a profile's summary: the comment in its first line.

    Raises:
        ConfigError: no such profile.
    """
    first = vehicle_text(vehicle).partition("\n")[0]
    return first.removeprefix("#").strip() if first.startswith("#") else ""
