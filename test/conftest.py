# SPDX-License-Identifier: Apache-2.0
"""What every test shares: its own corner of the network, and recorded data where there is any."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import pytest
from hypothesis import settings

# The same examples on every machine, and none that fails because the machine was busy.
settings.register_profile("steady", deadline=None, derandomize=True, database=None)
settings.load_profile("steady")

REPOSITORY = Path(__file__).resolve().parent.parent

# Before any test imports rclpy: nodes under test neither hear nor disturb others.
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ.setdefault("ROS_DOMAIN_ID", str(os.getpid() % 100 + 1))
os.environ["ROS_LOG_DIR"] = os.environ.get("ROS_LOG_DIR") or tempfile.mkdtemp(prefix="ros_log_")
os.environ.setdefault("MPLBACKEND", "Agg")


@pytest.fixture(scope="session")
def repository() -> Path:
    """Return the root of the source tree."""
    return REPOSITORY


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Return the folder of recorded flights, or skip: a user's clone does not hold them."""
    path = REPOSITORY.parent / "shared" / "data"
    if not path.is_dir():
        pytest.skip(f"no recorded flights: {path} is absent (it is not part of the repository)")
    return path
