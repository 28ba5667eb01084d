# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The tests run where ROS' launch_testing is installed, whose plugin newer pytests refuse."""

from __future__ import annotations

import os
import subprocess
import sys

# From launch_testing 3.4.3 (Jazzy) and launch_testing_ros 0.26.6: name of the entry point, and the
# hook that pytest 9 knows no longer, or that only the other one declares.
PLUGINS = {
    "launch_testing": "def pytest_pycollect_makemodule(path, parent): pass",
    "launch_ros": "def pytest_launch_collect_makemodule(path, parent, entrypoint): pass",
}


def test_plugins_of_launch_testing_are_left_out(tmp_path, repository):
    for name, hook in PLUGINS.items():
        (tmp_path / f"plugin_{name}.py").write_text(hook)
        about = tmp_path / f"{name}-3.4.3.dist-info"
        about.mkdir()
        (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 3.4.3\n")
        (about / "entry_points.txt").write_text(f"[pytest11]\n{name} = plugin_{name}\n")
    paths = os.pathsep.join([str(tmp_path), str(repository), *sys.path])

    def status(*more):
        return subprocess.run(
            [sys.executable, "-m", "pytest", "-q", *more, repository / "test/text"],
            cwd=repository,
            env=os.environ | {"PYTHONPATH": paths},
            capture_output=True,
            check=False,
        ).returncode

    assert status() == 0
    assert status("-o", "addopts=") != 0  # without our options the plugin does break it
