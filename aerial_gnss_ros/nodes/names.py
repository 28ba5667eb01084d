# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Validation of node, namespace and topic names."""

from __future__ import annotations

from rclpy.exceptions import NameValidationException
from rclpy.validate_namespace import validate_namespace
from rclpy.validate_topic_name import validate_topic_name

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.nodes.rivals import UNKNOWN


def absolute_namespace(given: str | None) -> str | None:
    """Return a namespace as rclpy expects it; None and the empty string unchanged.

    Raises:
        ConfigError: it is invalid.
    """
    if not given:
        return given
    absolute = "/" + given.strip("/")
    try:
        validate_namespace(absolute)
    except NameValidationException as error:
        raise ConfigError(f"{given!r} is not a valid namespace: {reason(error)}.") from error
    return absolute


def check_topic(topic: str) -> None:
    """Check the name of a topic.

    Raises:
        ConfigError: it is invalid.
    """
    try:
        validate_topic_name(topic)
    except NameValidationException as error:
        raise ConfigError(f"{topic!r} is not a valid topic: {reason(error)}.") from error


def full_name(name: str, namespace: str) -> str:
    """Return a node's fully qualified name as the graph shows it."""
    if name == "_NODE_NAME_UNKNOWN_":  # as rmw calls it
        return UNKNOWN
    return f"{namespace.rstrip('/')}/{name}"


def reason(error: NameValidationException) -> str:
    """Return what is wrong with a name, without rclpy's marker of the position."""
    return str(error).split("\n", 1)[0].split(": ", 1)[-1].rstrip(":. ")
