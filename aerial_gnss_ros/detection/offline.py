# SPDX-License-Identifier: Apache-2.0
"""Keeps ultralytics from the network: a robot has none, and must not wait for one."""

from __future__ import annotations

import os

OFFLINE = {"YOLO_OFFLINE": "true", "YOLO_AUTOINSTALL": "false"}
"""Environment variables that it reads when it is imported."""


def forbid_network() -> None:
    """Set `OFFLINE` where the user has not; before anything imports ultralytics."""
    for name, value in OFFLINE.items():
        os.environ.setdefault(name, value)
