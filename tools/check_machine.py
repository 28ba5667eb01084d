# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Says in one sentence what this machine lacks for `make`; ends with status 2 then.

Runs on Python versions that the package itself does not support, so it is written for them.
"""

import os
import platform
import shutil
import sys
import sysconfig
from pathlib import Path

OLDEST, NEWEST = (3, 10), (3, 13)
PACKAGES = "sudo apt install python3-venv python3-dev g++"


def complaint(with_ros: bool) -> str:
    """Return what is missing, or an empty string.

    Args:
        with_ros: True where ROS is sourced already, so that none has to be installed by pip.
    """
    if not OLDEST <= sys.version_info[:2] <= NEWEST:
        return (
            f"{sys.executable} is Python {platform.python_version()}, but 3.10 to 3.13 is needed: "
            "make PYTHON=python3.12 demo"
        )
    if not _has_module("ensurepip"):
        return "Python's venv module is incomplete: " + PACKAGES
    return "" if with_ros else _complaint_about_building()


def _complaint_about_building() -> str:
    """Return what is missing to install ROS from pip and compile its message packages."""
    system, machine = platform.system(), platform.machine()
    if (system, machine) != ("Linux", "x86_64"):
        return (
            f"pip has ROS 2 for Linux on x86_64 only, and this is {system} on {machine}: "
            "install ROS 2 Jazzy with apt and source it first"
        )
    if not (Path(sysconfig.get_path("include")) / "Python.h").is_file():
        return "Python's header files are missing: " + PACKAGES
    if not (shutil.which("g++") and shutil.which("gcc")):
        return "there is no C++ compiler (g++): " + PACKAGES
    return ""


def _has_module(name: str) -> bool:
    """Return whether a module can be imported."""
    try:
        __import__(name)
    except ImportError:
        return False
    return True


def main() -> int:
    """Print the complaint, if any, and return the exit status."""
    text = complaint(with_ros=bool(os.environ.get("AMENT_PREFIX_PATH")))
    if text:
        print("aerial_gnss_ros: " + text, file=sys.stderr)
    return 2 if text else 0


if __name__ == "__main__":
    sys.exit(main())
