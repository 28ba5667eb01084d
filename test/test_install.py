# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Real installations with pip, editable and with colcon: what is where, and does it start?"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from importlib.util import find_spec
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

REPOSITORY = Path(__file__).resolve().parent.parent
SITE = Path(sysconfig.get_path("purelib"))
SHIPPED = [
    path.relative_to(REPOSITORY)
    for folder in ("config", "models", "rviz")
    for path in sorted((REPOSITORY / folder).rglob("*"))
    if path.is_file() and not path.name.startswith(".")
]
# Into the environment of the Python that runs it, whatever this one holds; nothing is downloaded.
PIP_INSTALL = (
    *("-m", "pip", "install", "--quiet", "--ignore-installed"),
    *("--no-deps", "--no-build-isolation", "--no-index"),
)
FIND = """
import sys
from aerial_gnss_ros import resources
for folder, name in (text.split("/", 1) for text in sys.argv[1:]):
    print(getattr(resources, f"{folder.rstrip('s')}_path")(name))
"""


def environment(**more: str) -> dict[str, str]:
    """The environment of a fresh shell: no ROS sourced, nothing of this tree on the path."""
    drop = ("AMENT_", "COLCON_", "PYTHONPATH", "VIRTUAL_ENV")
    return {k: v for k, v in os.environ.items() if not k.startswith(drop)} | more


def call(*command: object, cwd: Path, **env: str) -> str:
    """Run a command outside this tree and return what it printed."""
    done = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=environment(**env),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{command} said:\n{done.stdout}\n{done.stderr}"
    return done.stdout


def check_resources(python: Path, cwd: Path, expected: Path, **env: str) -> None:
    """Every shipped file is found, below `expected`, and is the one of this tree."""
    found = call(python, "-c", FIND, *SHIPPED, cwd=cwd, **env).splitlines()
    assert [Path(line) for line in found] == [expected / name for name in SHIPPED]
    for line, name in zip(found, SHIPPED, strict=True):
        assert Path(line).read_bytes() == (REPOSITORY / name).read_bytes()


def make_venv(folder: Path) -> Path:
    """Create an environment that borrows this one's libraries and pip, but not its package."""
    call(sys.executable, "-m", "venv", "--without-pip", folder, cwd=folder.parent)
    python = folder / "bin" / "python"
    purelib = "import sysconfig; print(sysconfig.get_path('purelib'))"
    site = Path(call(python, "-c", purelib, cwd=folder).strip())
    (site / "borrowed.pth").write_text(f"{SITE}\n")
    return python


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the tree in a colcon workspace, so that builds leave nothing behind here."""
    copy = tmp_path_factory.mktemp("workspace") / "src" / "aerial_gnss_ros"
    ignore = shutil.ignore_patterns(
        ".*", "build", "install", "log", "test", "*.egg-info", "__pycache__", "demo_*"
    )
    shutil.copytree(REPOSITORY, copy, ignore=ignore)
    return copy


def test_shipped_files_include_configuration_and_a_model() -> None:
    suffixes = {path.suffix for path in SHIPPED}
    assert {".yaml", ".onnx", ".md"} <= suffixes


def test_pip(source: Path, tmp_path: Path) -> None:
    python = make_venv(tmp_path / "venv")
    call(python, *PIP_INSTALL, source, cwd=tmp_path)
    check_resources(python, tmp_path, tmp_path / "venv" / "share" / "aerial_gnss_ros")
    commands = {path.name for path in (tmp_path / "venv" / "bin").iterdir()}
    assert {f"aerial-gnss{name}" for name in ("", "-detector", "-estimator", "-fleet")} <= commands
    assert not {"detector", "estimator", "fleet"} & commands
    help_text = call(tmp_path / "venv" / "bin" / "aerial-gnss", "--help", cwd=tmp_path)
    assert "replay" in help_text
    installed = {path.name for path in (tmp_path / "venv").glob("lib/python*/site-packages/*")}
    assert "aerial_gnss_ros" in installed
    assert not {"fuzz", "benchmarks", "test", "tools"} & installed


def test_pip_editable(source: Path, tmp_path: Path) -> None:
    python = make_venv(tmp_path / "venv")
    call(python, *PIP_INSTALL, "--editable", source, cwd=tmp_path)
    check_resources(python, tmp_path, source)
    assert "replay" in call(tmp_path / "venv" / "bin" / "aerial-gnss", "--help", cwd=tmp_path)


@pytest.fixture(scope="module")
def apt_like(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The libraries without the records of pip, as apt installs them (OpenCV for example)."""
    folder = tmp_path_factory.mktemp("dist_packages")
    for path in SITE.iterdir():
        if path.suffix not in (".dist-info", ".egg-info", ".pth", ".egg-link"):
            (folder / path.name).symlink_to(path)
    return folder


@pytest.mark.parametrize("layout", ["isolated", "merge", "symlink"])
def test_colcon(layout: str, source: Path, tmp_path: Path, apt_like: Path) -> None:
    options = [] if layout == "isolated" else [f"--{layout}-install"]
    workspace = source.parent.parent
    call(
        *(sys.executable, "-m", "colcon", "--log-base", tmp_path / "log", "build"),
        *("--build-base", tmp_path / "build", "--install-base", tmp_path / "install", *options),
        cwd=workspace,
    )
    prefix = tmp_path / "install" / ("" if layout == "merge" else "aerial_gnss_ros")
    share = prefix / "share" / "aerial_gnss_ros"
    executables = prefix / "lib" / "aerial_gnss_ros"
    assert (prefix / "share/ament_index/resource_index/packages/aerial_gnss_ros").is_file()
    assert (share / "package.xml").is_file()
    assert list((share / "launch").glob("*.launch.py"))
    names = {"aerial-gnss", "detector", "estimator", "fleet"}
    assert {p.name for p in executables.iterdir()} == names
    assert not (tmp_path / "install" / "aerial-gnss-interfaces").exists()

    sourced = call(
        *("bash", "-c", '. "$0" >&2 && printf %s "$PYTHONPATH"', tmp_path / "install/setup.bash"),
        cwd=tmp_path,
    )
    env = {"PYTHONPATH": f"{sourced}:{apt_like}"}
    python = tmp_path / "bare" / "bin" / "python"
    call(sys.executable, "-m", "venv", "--without-pip", tmp_path / "bare", cwd=tmp_path)
    linked = (tmp_path / "build/aerial_gnss_ros/aerial_gnss_ros").is_symlink()
    assert layout == "symlink" or not linked  # newer setuptools: --symlink-install copies, too
    check_resources(python, tmp_path, source if linked else share, **env)
    assert "replay" in call(python, executables / "aerial-gnss", "--help", cwd=tmp_path, **env)
    for node in ("detector", "estimator") if find_spec("rclpy") else ():
        text = call(python, executables / node, "--help", cwd=tmp_path, **env)
        assert text.startswith(f"usage: {node} ")
