# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Builds the Python modules vision_msgs, geographic_msgs and tf2_msgs against the ROS 2 wheels."""

import os
import sys
from pathlib import Path

from setuptools import setup

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))  # pip's build environment does not hold the folder it builds

from build_messages import guard  # noqa: E402


def arguments() -> dict[str, object]:
    """Generate the sources and return what setuptools needs to compile and pack them."""
    from build_messages import compilation, generation, texts

    packages = texts.read(HERE)
    folder = generation.generate_all(packages, HERE / "build" / "ros")
    return {
        "packages": [name for package in packages for name in (package, f"{package}.msg")],
        "package_dir": {p: str((folder / "py" / p).relative_to(HERE)) for p in packages},
        "ext_modules": [compilation.extension(p, folder, HERE) for p in packages],
        "exclude_package_data": {"": ["*.c"]},
        "options": {"build_ext": {"parallel": os.cpu_count()}},
    }


guard.refuse_beside_ros()
ONLY_METADATA = not {"egg_info", "dist_info", "sdist"}.isdisjoint(sys.argv)
setup(**({"py_modules": []} if ONLY_METADATA else arguments()))
