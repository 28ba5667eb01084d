# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Keeps ultralytics from the network, and from the user's home: a robot has none, or a full one."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from pathlib import Path

QUIET = {"YOLO_VERBOSE": "false"}
"""Keeps its talk out of standard output, where our results go; read when it is imported, too."""
OFFLINE = {"YOLO_OFFLINE": "true", "YOLO_AUTOINSTALL": "false"}
"""Environment variables that it reads when it is imported."""
SETTINGS = "YOLO_CONFIG_DIR"
"""Names the folder of its settings, also when it is imported; else they are in the user's home."""


def forbid_network() -> None:
    """Set these variables where the user has not; before anything imports ultralytics."""
    for name, value in {**OFFLINE, **QUIET}.items():
        os.environ.setdefault(name, value)
    settings_folder()


def settings_folder() -> Path:
    """Return the folder of its settings: the user's, or one that goes with this process."""
    if not os.environ.get(SETTINGS):
        os.environ[SETTINGS] = tempfile.mkdtemp(prefix="aerial_gnss_")
        atexit.register(shutil.rmtree, os.environ[SETTINGS], ignore_errors=True)
    return Path(os.environ[SETTINGS])
