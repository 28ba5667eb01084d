# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Keeps ultralytics off the network and out of the user's home, which may be full or absent."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from pathlib import Path

QUIET = {"YOLO_VERBOSE": "false"}
"""Keeps its messages off standard output, which carries results; read on import, too."""
OFFLINE = {"YOLO_OFFLINE": "true", "YOLO_AUTOINSTALL": "false"}
"""Environment variables that it reads on import."""
SETTINGS = "YOLO_CONFIG_DIR"
"""Names the folder of its settings, read on import; otherwise they are in the user's home."""


def forbid_network() -> None:
    """Set these variables unless the user has; call it before ultralytics is imported."""
    for name, value in {**OFFLINE, **QUIET}.items():
        os.environ.setdefault(name, value)
    settings_folder()


def settings_folder() -> Path:
    """Return the folder of its settings: the user's, or a temporary one of this process."""
    if not os.environ.get(SETTINGS):
        os.environ[SETTINGS] = tempfile.mkdtemp(prefix="aerial_gnss_")
        atexit.register(shutil.rmtree, os.environ[SETTINGS], ignore_errors=True)
    return Path(os.environ[SETTINGS])
