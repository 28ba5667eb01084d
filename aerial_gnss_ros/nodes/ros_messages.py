# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Messages of rclpy from nested dicts in ROS field names."""

from __future__ import annotations

import array
import functools
import importlib
from typing import Any

from aerial_gnss_ros.core.values.errors import RosError
from aerial_gnss_ros.resources import ros_distribution


@functools.cache
def message_class(msgtype: str) -> Any:
    """Return the class of a message type.

    Args:
        msgtype: such as `sensor_msgs/msg/NavSatFix`.

    Raises:
        RosError: the type's package is not installed, or has no such message.
    """
    package, _, name = msgtype.partition("/msg/")
    try:
        return getattr(importlib.import_module(f"{package}.msg"), name)
    except (ImportError, AttributeError) as error:
        raise RosError(
            f"message type {msgtype} is not installed ({error}); {_remedy(package)}."
        ) from error


def _remedy(package: str) -> str:
    """Return how to install a message package."""
    if package == "px4_msgs":
        return (
            "build px4_msgs of the firmware's release in a colcon workspace and source it, or "
            "choose another vehicle profile"
        )
    apt = f"ros-{ros_distribution()}-{package.replace('_', '-')}"
    if package == "mavros_msgs":
        return f"install {apt} (it comes with MAVROS), or choose another vehicle profile"
    return f"on a robot install {apt}, elsewhere interfaces/ with pip"


def message(msgtype: str, fields: dict[str, Any]) -> Any:
    """Return a message; fields absent from `fields` keep their defaults (zero, empty, identity).

    Raises:
        RosError: the type is not installed.
        AttributeError: the type has no field of a given name.
    """
    made = message_class(msgtype)()
    _fill(made, fields)
    return made


def _fill(made: Any, fields: dict[str, Any]) -> None:
    for name, value in fields.items():
        if isinstance(value, dict):
            _fill(getattr(made, name), value)
        elif isinstance(value, list | tuple) and value and isinstance(value[0], dict):
            element = _element(
                made.get_fields_and_field_types()[name]
            )  # copies the list, so only here
            setattr(made, name, [message(element, item) for item in value])
        else:
            setattr(made, name, _plain(getattr(made, name), value))


def _plain(default: Any, value: Any) -> Any:
    """Return a value in its field's own type; rclpy copies lists into arrays element by element."""
    if isinstance(default, array.array):
        return array.array(default.typecode, value)
    return value


def _element(kind: str) -> str:
    """Return `sensor_msgs/msg/X` for `sequence<sensor_msgs/X>`, `sequence<…, 3>` and `…/X[3]`."""
    inner = kind.removeprefix("sequence<").split("[")[0].split(",")[0].rstrip(">")
    package, _, name = inner.partition("/")
    return f"{package}/msg/{name}"
