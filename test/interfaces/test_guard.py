# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""interfaces/ refuses to install beside a ROS that has these packages."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SETUP = Path(__file__).resolve().parents[2] / "interfaces" / "setup.py"


def run_setup(prefixes: str) -> subprocess.CompletedProcess[str]:
    env = {**os.environ, "AMENT_PREFIX_PATH": prefixes}
    command = [sys.executable, str(SETUP), "sdist", "--help"]
    return subprocess.run(
        command, cwd=SETUP.parent, env=env, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("package", ["vision_msgs", "geographic_msgs"])
def test_refuses_where_ros_has_the_package(package: str, tmp_path: Path) -> None:
    (tmp_path / "jazzy" / "share" / package).mkdir(parents=True)
    done = run_setup(f"{tmp_path}/overlay:{tmp_path}/jazzy")
    assert done.returncode != 0
    assert f"ROS already provides {tmp_path}/jazzy/share/{package}" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("prefixes", ["", "/nowhere", "/nowhere:"])
def test_goes_on_where_ros_has_none(prefixes: str) -> None:
    assert run_setup(prefixes).returncode == 0
