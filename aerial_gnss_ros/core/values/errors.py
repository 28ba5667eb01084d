# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Errors that a user can act on: one sentence with the value seen and a remedy."""

from __future__ import annotations


class AerialGnssError(Exception):
    """Base of every error that the user can fix; `aerial-gnss` exits with status 2."""


class ConfigError(AerialGnssError):
    """A parameter is unknown, of the wrong type, or out of its range."""


class CameraError(AerialGnssError):
    """A camera description is unusable: zeros, an unknown distortion model, a wrong size."""


class InputError(AerialGnssError):
    """A file, bag or message is unusable: missing, truncated, unknown type or encoding."""


class OutputError(AerialGnssError):
    """A result cannot be written: the folder exists already, or the disk is full."""


class ModelError(AerialGnssError):
    """A detection model is missing, is not a model, or has the wrong input or output."""


class StateError(Exception):
    """The filter has reached an impossible state: an internal error that no user can fix."""


class RosError(AerialGnssError):
    """ROS 2 is not installed, or a message package is missing."""
