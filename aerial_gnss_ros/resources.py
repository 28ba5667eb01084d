# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Finds the configuration and models that come with the package, however it was installed.

`setup.py` installs the folders to `<prefix>/share/aerial_gnss_ros`, where ROS expects them. The
prefix is some folder above the package itself: of a virtual environment, of `pip install --user`,
of `/usr/local`, or of a colcon workspace, merged or not. In a source tree, which is what an
editable installation runs from, they lie beside the package.
"""

from __future__ import annotations

import os
from pathlib import Path

from aerial_gnss_ros.core.values.errors import InputError

NAME = "aerial_gnss_ros"
_PACKAGE = Path(__file__).resolve().parent
# <prefix>/lib/python3.12/site-packages/aerial_gnss_ros; Debian has one folder more (local/).
_DEEPEST_PREFIX = 5


def config_path(name: str) -> Path:
    """Return a configuration file or folder, such as `estimator.yaml` or `vehicles`.

    Args:
        name: Path relative to config/.

    Raises:
        InputError: The package has no such file.
    """
    return _resource("config", name)


def model_path(name: str) -> Path:
    """Return a shipped model or its card, such as `aqua.onnx`.

    Args:
        name: Path relative to models/.

    Raises:
        InputError: The package has no such file.
    """
    return _resource("models", name)


def rviz_path(name: str) -> Path:
    """Return a configuration of a viewer, such as `aerial_gnss.rviz`.

    Args:
        name: Path relative to rviz/.

    Raises:
        InputError: The package has no such file.
    """
    return _resource("rviz", name)


def install_hint(extra: str = "") -> str:
    """Return how to install an extra, such as `pip install ".[mavlink]"` in this folder.

    Always from this package's own folder: its name alone would be looked up on a public index,
    where anybody can register it.

    Args:
        extra: its name in setup.py; empty: what the package itself needs.
    """
    source_tree = _PACKAGE.parent
    has_source = (source_tree / "setup.py").is_file()
    where = str(source_tree) if has_source else "the folder that this package was installed from"
    what = f'".[{extra}]"' if extra else "."
    return f"`pip install {what}` in {where}"


def ros_distribution(installed: Path = Path("/opt/ros")) -> str:
    """Return the name of the ROS 2 distribution: sourced, else installed, else jazzy.

    Args:
        installed: where apt puts distributions.
    """
    found = sorted(path.parent.name for path in installed.glob("*/setup.bash"))
    return os.environ.get("ROS_DISTRO") or (found[-1] if found else "jazzy")


def _resource(folder: str, name: str) -> Path:
    """Return `folder/name` below the resource root, or say what there is instead."""
    root = resource_root(_PACKAGE)
    path = root / folder / name
    if not path.exists():
        present = sorted(p.name for p in (root / folder).glob("*"))
        raise InputError(
            f"{NAME} comes without {folder}/{name}; {root / folder} holds "
            f"{', '.join(present) or 'nothing'}."
        )
    return path


def resource_root(package: Path) -> Path:
    """Return the folder that holds config/, models/ and rviz/.

    Args:
        package: The folder of the Python package, symbolic links resolved.

    Raises:
        InputError: The installation is incomplete.
    """
    source_tree = package.parent
    if (source_tree / "package.xml").is_file() and (source_tree / "config").is_dir():
        return source_tree
    for prefix in package.parents[:_DEEPEST_PREFIX]:
        share = prefix / "share" / NAME
        if share.is_dir():
            return share
    raise InputError(
        f"the files of {NAME} are missing: no folder above {package} has share/{NAME}; "
        "install the package with pip or colcon, do not copy its Python files alone"
    )
