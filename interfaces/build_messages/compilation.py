# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Describes the extension module of one message package to setuptools."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from setuptools import Extension

from build_messages.generation import DEPENDENCIES, TYPE_SUPPORTS, ros_prefix

RUNTIME = (
    "rosidl_runtime_c",
    "rosidl_typesupport_c",
    *TYPE_SUPPORTS,
    "rosidl_typesupport_fastrtps_cpp",
    "fastcdr",
    "rcutils",
)
KINDS = ("rosidl_generator_c", "rosidl_generator_py", *TYPE_SUPPORTS)


def extension(package: str, folder: Path, here: Path) -> Extension:
    """Return the module `<package>_s__rosidl_typesupport_c`, the name that rclpy imports.

    Args:
        package: Name of the message package.
        folder: What `generation.generate_all` filled.
        here: The folder interfaces/; setuptools wants source paths relative to it.
    """
    sources = [
        str(path.relative_to(here))
        for part in ("structures", "introspection", "py")
        for path in sorted((folder / part / package).rglob("*.c*"))
    ]
    return Extension(
        f"{package}.{package}_s__rosidl_typesupport_c",
        sources,
        include_dirs=_include_dirs(folder),
        library_dirs=[str(ros_prefix() / "lib")],
        libraries=[*RUNTIME, *(f"{name}__{kind}" for name in DEPENDENCIES for kind in KINDS)],
        extra_compile_args=["-O1", "-g0", "-w"],
        # The ROS libraries lie in the environment's lib/, three folders above the module.
        extra_link_args=["-Wl,--as-needed", "-s", "-Wl,-rpath,$ORIGIN/../../.."],
    )


def _include_dirs(folder: Path) -> list[str]:
    """Return generated headers, numpy's, and the wheels' (each package in a folder of its own)."""
    include = ros_prefix() / "include"
    packages = [path for path in sorted(include.iterdir()) if path.is_dir()]
    generated = [folder / part for part in ("structures", "introspection", "py")]
    return [*map(str, generated), np.get_include(), str(include), *map(str, packages)]
