# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Chooses the Fast DDS profile for processes of this package: large images, or prompt discovery."""

from __future__ import annotations

import os
from collections.abc import MutableMapping
from pathlib import Path

from aerial_gnss_ros.resources import config_path

PROFILE, PROMPT = "fastdds_large_data.xml", "fastdds_prompt.xml"
VARIABLE = "FASTRTPS_DEFAULT_PROFILES_FILE"  # the variable that Jazzy's Fast DDS 2.14 reads
# Users may choose transports with these; any of them takes precedence.
_USERS_OWN = (VARIABLE, "FASTDDS_DEFAULT_PROFILES_FILE", "FASTDDS_BUILTIN_TRANSPORTS")
_USERS_FILES = ("DEFAULT_FASTRTPS_PROFILES.xml", "DEFAULT_FASTDDS_PROFILES.xml")


def use_large_data_profile(environment: MutableMapping[str, str] = os.environ) -> bool:
    """Select a transport that delivers large images; call it before rclpy is initialised.

    Args:
        environment: in which the variable is set.

    Returns:
        False if the user has chosen transports, which are left unchanged.
    """
    return _use(PROFILE, environment)


def use_prompt_profile(environment: MutableMapping[str, str] = os.environ) -> bool:
    """Let this process be found within half a second by programs that start later.

    Args:
        environment: in which the variable is set.

    Returns:
        False if the user has chosen transports, which are left unchanged.
    """
    return _use(PROMPT, environment)


def _use(profile: str, environment: MutableMapping[str, str]) -> bool:
    if any(environment.get(name) for name in _USERS_OWN):
        return False
    if any(Path(name).is_file() for name in _USERS_FILES):
        return False
    environment[VARIABLE] = str(config_path(profile))
    return True
