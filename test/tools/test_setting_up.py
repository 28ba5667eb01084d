# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What `make` installs, and what it says on a machine that lacks something."""

from __future__ import annotations

import importlib.util
import os
import subprocess
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "tools" / "check_machine.py"
SPEC = importlib.util.spec_from_file_location("check_machine", SCRIPT)
check_machine = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(check_machine)


def test_this_machine_lacks_nothing() -> None:
    assert check_machine.complaint(with_ros=False) == ""


@pytest.mark.parametrize("version", [(2, 7, 18), (3, 9, 20), (3, 14, 0)])
def test_python_of_another_version(version: tuple, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check_machine.sys, "version_info", version)
    assert "3.10 to 3.13 is needed" in check_machine.complaint(with_ros=True)


def test_no_venv_module(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check_machine, "_has_module", lambda name: name != "ensurepip")
    assert "sudo apt install python3-venv" in check_machine.complaint(with_ros=True)


def test_no_headers(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(check_machine.sysconfig, "get_path", lambda name: str(tmp_path / name))
    assert "header files are missing" in check_machine.complaint(with_ros=False)
    assert check_machine.complaint(with_ros=True) == ""


def test_no_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check_machine.shutil, "which", lambda _: None)
    assert "no C++ compiler" in check_machine.complaint(with_ros=False)


def test_arm_without_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check_machine.platform, "machine", lambda: "aarch64")
    assert "Linux on aarch64: install ROS 2 Jazzy" in check_machine.complaint(with_ros=False)
    assert check_machine.complaint(with_ros=True) == ""


def test_make_says_it_in_one_sentence_and_leaves_nothing(tmp_path: Path) -> None:
    old = tmp_path / "python3"
    old.write_text('#!/bin/sh\necho "aerial_gnss_ros: this Python is too old" >&2; exit 2\n')
    old.chmod(0o755)
    done = subprocess.run(
        ["make", f"PYTHON={old}", f"VENV={tmp_path}/venv", "demo"],
        cwd=SCRIPT.parent.parent,
        env={k: v for k, v in os.environ.items() if not k.startswith("MAKE")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.splitlines()[0] == "aerial_gnss_ros: this Python is too old"
    assert not (tmp_path / "venv").exists()


def test_make_leaves_ros_to_apt_where_it_is_sourced() -> None:
    def plan(**env: str) -> str:
        clean = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "AMENT_"))}
        return subprocess.run(
            ["make", "-n", "VENV=/nowhere", "demo"],
            cwd=SCRIPT.parent.parent,
            env=clean | env,
            capture_output=True,
            text=True,
            check=True,
        ).stdout

    assert "./interfaces" in plan()
    assert "[ros]" in plan()
    beside_ros = plan(AMENT_PREFIX_PATH="/opt/ros/jazzy")
    assert "./interfaces" not in beside_ros
    assert "[ros]" not in beside_ros
    assert "numpy<2" in beside_ros
