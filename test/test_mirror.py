# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tests mirror the package: aerial_gnss_ros/ROOM/NAME.py is tested by test/ROOM/test_NAME.py."""

from __future__ import annotations

import ast
from collections import Counter
from functools import cache
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parent
ROOT = TESTS.parent
PACKAGE = ROOT / "aerial_gnss_ros"

# Modules that are tested by what is made with them, by the test that does so: whole files,
# commands, nodes and pictures are the smallest things whose result anybody can check by other
# means. None of core is among them.
TESTED_WITH = {
    "benchmarking/test_figures.py": (
        "benchmarking/live benchmarking/machine benchmarking/one_process benchmarking/processes"
    ),
    "benchmarks/test_soak.py": "benchmarking/disturbing",
    "commands/test_augment.py": "commands/dataset_arguments training/augment",
    "commands/test_benchmark.py": "benchmarking/flight benchmarking/suite",
    "commands/test_camera.py": "commands/camera_arguments",
    "commands/test_check.py": "commands/check_report",
    "commands/test_evaluate.py": "evaluation/figures",
    "commands/test_import_dji.py": "bags/import_dji commands/import_report",
    "commands/test_replay.py": "bags/replay",
    "commands/test_replay_drones.py": "bags/replay_drones commands/drone_arguments",
    "commands/test_simulate.py": "commands/simulate_arguments",
    "commands/test_stream.py": "commands/udp_outputs",
    "commands/test_train.py": "commands/train_arguments",
    "commands/test_teach.py": (
        "teaching/clicks teaching/dataset teaching/recording teaching/telemetry"
    ),
    "detection/test_roi.py": "detection/windowed",
    "detection/test_select.py": "detection/config detection/openvino_backend",
    "detection/test_tensorrt_backend.py": "detection/cuda detection/engine_card training/engine",
    "nodes/test_arrivals.py": "nodes/inputs",
    "nodes/test_detector.py": "nodes/detector_node nodes/qos nodes/supervised",
    "nodes/test_estimator.py": "nodes/estimator_node nodes/positions",
    "nodes/test_fleet.py": "nodes/fleet_node",
    "nodes/test_play.py": "commands/play nodes/pausing",
    "nodes/test_process.py": "nodes/executable nodes/leaving",
    "nodes/test_run.py": "commands/run",
    "nodes/test_stream.py": "nodes/robots",
    "nodes/test_where.py": "commands/where",
    "preflight/test_sign_tests.py": "preflight/verdict",
    "simulation/blender/test_labels.py": (
        "simulation/blender/masks simulation/blender/nodes simulation/blender/ocean "
        "simulation/blender/picture simulation/blender/ranges simulation/blender/rig "
        "simulation/blender/studio simulation/blender/tracing simulation/samples"
    ),
    "simulation/blender/test_samples.py": "simulation/blender/worker",
    "simulation/blender/test_shot.py": "simulation/blender/hexapod simulation/blender/props",
    "simulation/test_afloat.py": "simulation/props simulation/scenario",
    "simulation/test_bag.py": "simulation/imaging",
    "simulation/test_dataset.py": "simulation/fast_samples simulation/sample_source",
    "simulation/test_flotsam.py": "simulation/filling simulation/staging",
    "simulation/test_renderer.py": (
        "simulation/raster simulation/scene simulation/shading simulation/wash"
    ),
    "teaching/test_session.py": "teaching/tracks",
    "training/test_second_look_network_pretrained.py": "training/backbone",
    "training/test_second_look.py": (
        "training/proposals training/second_look_network training/second_look_network_fit"
    ),
    "training/test_small.py": (
        "training/small_batch training/small_network training/small_samples"
    ),
    "training/test_supervise.py": "training/offline training/results training/worker",
    "training/test_train.py": "training/export",
}

# Modules that no test runs in this process.
NOT_RUN = {
    "nodes/both": "two nodes in one process: a launch file starts it, see nodes/test_launch.py",
    "benchmarking/camera": "a program of the live benchmark, started by it",
    "benchmarking/pair": "a program of the live benchmark, started by it",
}


def _name(path: Path) -> str:
    return path.relative_to(PACKAGE).with_suffix("").as_posix()


def _has_code(path: Path) -> bool:
    """Return whether a module has a function that does anything."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.FunctionDef) and not all(
            isinstance(one, ast.Expr | ast.Pass) for one in node.body
        ):
            return True
    return False


MODULES = {_name(path): path for path in PACKAGE.rglob("*.py") if path.name != "__init__.py"}
OWN_TEST = {
    name: path
    for name in MODULES
    if (path := (TESTS / name).with_name(f"test_{Path(name).name}.py")).exists()
}
LISTED = [(test, name) for test, names in TESTED_WITH.items() for name in names.split()]


@cache
def _imported(path: Path) -> frozenset[str]:
    """Return the modules of the package that a file imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)}
    slashed = {one.removeprefix("aerial_gnss_ros.").replace(".", "/") for one in found}
    return frozenset(slashed & MODULES.keys())


def _reached(test: Path) -> set[str]:
    """Return the modules that a test imports or whose name it has, and what these import."""
    helpers = (one for folder in test.parents if TESTS in (folder, *folder.parents)
               for one in folder.glob("*.py") if not one.name.startswith("test_"))  # fmt: skip
    left = {name for one in (test, *helpers) for name in _imported(one)}
    left |= {name for name in MODULES if f"test_{Path(name).name}.py" == test.name}
    found: set[str] = set()
    while left:
        found |= left
        left = {one for name in left for one in _imported(MODULES[name])} - found
    return found


def test_every_module_has_a_test_of_its_name_or_is_listed_with_another() -> None:
    listed = Counter([*(name for _, name in LISTED), *NOT_RUN])
    assert listed.keys() <= MODULES.keys(), "listed, and not there"
    needed = {name for name in MODULES if name not in OWN_TEST and _has_code(MODULES[name])}
    assert needed <= listed.keys(), "these have no test of their name: write test/ROOM/test_NAME.py"
    assert listed.keys() <= needed, "these need no other test: take them off the list"
    assert set(listed.values()) == {1}, "a module is listed once"
    assert not [name for name in listed if name.startswith("core/")], "write its own test"


@pytest.mark.parametrize("test", TESTED_WITH)
def test_a_test_that_is_listed_reaches_its_modules(test: str) -> None:
    assert set(TESTED_WITH[test].split()) <= _reached(TESTS / test)
