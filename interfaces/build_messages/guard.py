# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Keeps these modules away from a ROS installation that has its own."""

from __future__ import annotations

import os
from pathlib import Path

PACKAGES = ("vision_msgs", "geographic_msgs", "tf2_msgs")


def installed_elsewhere(prefixes: str) -> list[Path]:
    """Return where a ROS installation already provides one of the packages.

    Args:
        prefixes: Folders joined by `:`, as in AMENT_PREFIX_PATH; empty where no ROS is sourced.
    """
    found = (
        Path(prefix) / "share" / name
        for prefix in prefixes.split(os.pathsep)
        if prefix
        for name in PACKAGES
    )
    return [path for path in found if path.is_dir()]


def refuse_beside_ros() -> None:
    """End the installation where the sourced ROS has these packages.

    Two builds of one message in one process end in undefined symbols at best.
    """
    found = installed_elsewhere(os.environ.get("AMENT_PREFIX_PATH", ""))
    if found:
        raise SystemExit(
            f"aerial-gnss-interfaces is not needed here: ROS already provides {found[0]}. "
            "Use that one, or open a shell in which no ROS is sourced."
        )
