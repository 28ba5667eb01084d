# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The launch file in ROS' own launch; skipped where that is absent, as it is from PyPI."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

pytest.importorskip("launch_ros", reason="ROS' launch and launch_ros are not installed")
pytest.importorskip("rclpy", reason="ROS 2 is not installed")

RUN = """
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import GroupAction, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_ros.actions import PushRosNamespace

path, *given = sys.argv[1:]
source = PythonLaunchDescriptionSource(path)
included = IncludeLaunchDescription(source, launch_arguments=[a.split(":=") for a in given])
service = LaunchService()
group = GroupAction([PushRosNamespace("fleet"), included])
service.include_launch_description(LaunchDescription([group]))
sys.exit(service.run())
"""


@pytest.fixture
def launch(repository, tmp_path):
    """Return a function that runs the launch file below the namespace fleet."""
    package = "aerial_gnss_ros"
    index = tmp_path / "share" / "ament_index" / "resource_index" / "packages"
    program = tmp_path / "lib" / package / "aerial-gnss"
    for folder in (index, program.parent, tmp_path / "share" / package):
        folder.mkdir(parents=True)
    (index / package).touch()
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m {package}.cli "$@"\n')
    program.chmod(0o755)
    prefixes = [str(tmp_path), os.environ.get("AMENT_PREFIX_PATH", "")]
    paths = [str(repository), *sys.path]

    def run(*arguments):
        return subprocess.run(
            [sys.executable, "-c", RUN, repository / "launch/aerial_gnss.launch.py", *arguments],
            cwd=tmp_path,
            env=os.environ
            | {
                "AMENT_PREFIX_PATH": os.pathsep.join(filter(None, prefixes)),
                "PYTHONPATH": os.pathsep.join(filter(None, paths)),
                "RCUTILS_COLORIZED_OUTPUT": "0",
            },
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=120.0,
            check=False,
        )

    return run


def test_wrong_parameters_end_it_with_an_error(launch, tmp_path):
    (tmp_path / "p.yaml").write_text("max_wiat: 1.0\n")
    ended = launch(f"params:={tmp_path}/p.yaml")
    assert ended.returncode == 1, ended.stdout
    assert "max_wiat is not a parameter; did you mean max_wait?" in ended.stdout


def test_a_bag_that_cannot_be_played_ends_it_with_an_error(launch, tmp_path):
    ended = launch(f"bag:={tmp_path}/absent")
    assert ended.returncode == 1, ended.stdout
    assert "absent does not exist" in ended.stdout


def test_a_bag_meets_the_namespaces_and_its_end_ends_all(launch, flight):
    ended = launch(f"bag:={flight('images', 3.0)}", "namespace:=drone1", "log_level:=info")
    assert ended.returncode == 0, ended.stdout
    assert "first image from /fleet/drone1/camera/image_raw: 640 x 360" in ended.stdout
    assert "[fleet.drone1.estimator]: The origin of map is 13.19394" in ended.stdout
    assert "the bag has ended" in ended.stdout or "played" in ended.stdout
