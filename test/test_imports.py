# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Nothing imports what lies above it, and the default path needs neither ROS nor torch to load."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / "aerial_gnss_ros"
NAME = PACKAGE.name
ROS = {"rclpy", "rosidl_runtime_py", "ament_index_python", "launch", "launch_ros"}
OPTIONAL = {"torch", "ultralytics", "openvino", "tensorrt"}
BLENDER = {"bpy", "mathutils"}

# From the ground up; parts on one floor do not know each other.
FLOORS = [
    {"text"},
    {"core"},
    {"resources", "preflight"},
    {"adapters"},
    {"detection", "calibration"},
    {"bags"},
    {"simulation", "evaluation"},
    {"training"},
    {"teaching"},
    {"nodes"},
    {"view"},
    {"benchmarking"},
    {"commands"},
    {"cli"},
]
FLOOR = {part: level for level, parts in enumerate(FLOORS) for part in parts}

# The rooms of core from the ground up: each may import those before it.
ROOMS = [
    "values",
    "numerics",
    "geometry",
    "camera",
    "config",
    "telemetry",
    "georeferencing",
    "models",
    "faults",
    "filter",
    "association",
    "identity",
    "references",
    "tracker",
    "estimation",
    "fleet",
]
USE_TEXT = {"config", "telemetry", "filter", "identity"}
"""Rooms that write sentences or read text: they may import `text` as well."""

# Libraries beyond Python's own that a part may import; None: any.
MAY_IMPORT = {
    "text": set(),
    "preflight": {"numpy"},
    "core": {"numpy", "scipy", "pyproj", "pygeomag"},
    "resources": set(),
    "adapters": {"numpy", "scipy", "yaml", "PIL"},
}

CORE = PACKAGE / "core"
MODULES = sorted(path for path in PACKAGE.rglob("*.py"))
FOLDERS = sorted({path.parent for path in MODULES})
IDS = [str(path.relative_to(PACKAGE.parent)) for path in FOLDERS]


@cache
def imports(path: Path) -> list[tuple[str, int]]:
    """Every imported module of a file, wherever the statement stands, with its line."""
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found += [(alias.name, node.lineno) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: relative import"
            found += [(f"{node.module}.{alias.name}", node.lineno) for alias in node.names]
    return found


def part_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def is_ros(name: str) -> bool:
    return name in ROS or name.endswith(("_msgs", "_interfaces"))


@pytest.mark.parametrize("folder", FOLDERS, ids=IDS)
def test_nothing_imports_what_lies_above_it(folder: Path) -> None:
    for path in folder.glob("*.py"):
        part = part_of(path)
        for name, line in imports(path):
            words = name.split(".")
            if words[0] == NAME and part != "__init__" and words[1] in FLOOR:
                below = FLOOR[words[1]] < FLOOR[part] or words[1] == part
                assert below, f"{path}:{line}: {part} imports {name}"


def test_no_files_import_each_other_in_a_circle() -> None:
    names = {".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts) for path in MODULES}
    order = TopologicalSorter[str]()
    for path in MODULES:
        own = ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts)
        used = {name if name in names else name.rpartition(".")[0] for name, _ in imports(path)}
        order.add(own, *(used & names) - {own})
    order.prepare()  # raises CycleError with the circle


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_of_core_imports_only_those_below(room: str) -> None:
    below = {f"core.{one}" for one in ROOMS[: ROOMS.index(room) + 1]}
    below |= {"text"} if room in USE_TEXT else set()
    for path in sorted((CORE / room).rglob("*.py")):
        for name, line in imports(path):
            if name.startswith(f"{NAME}."):
                inside = name.removeprefix(f"{NAME}.")
                assert any(inside.startswith(f"{one}.") for one in below), (
                    f"{path}:{line}: {room} imports {name}"
                )


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_says_in_two_sentences_what_it_knows_and_may_import(room: str) -> None:
    opening = CORE / room / "__init__.py"
    tree = ast.parse(opening.read_text())
    assert len(tree.body) == 1, f"{opening} holds more than its docstring"
    what, _, permission = (ast.get_docstring(tree) or "").partition("\n\n")
    assert what.endswith(".")
    text = ["text"] if room in USE_TEXT else []
    below = ROOMS[: ROOMS.index(room)]
    some = [*text, *below] if len(below) < 4 else [*text, f"the rooms of core up to {below[-1]}"]
    listed = " and ".join(filter(None, (", ".join(some[:-1]), *some[-1:])))
    expected = f"May import {listed}." if some else "Imports nothing of this package."
    assert permission == expected


def test_core_consists_of_its_rooms() -> None:
    assert {path.name for path in CORE.glob("*.py")} == {"__init__.py"}
    assert {path.parent.name for path in CORE.glob("*/*.py")} == set(ROOMS)


@pytest.mark.parametrize("folder", FOLDERS, ids=IDS)
def test_libraries_stay_on_their_floor(folder: Path) -> None:
    for path in folder.glob("*.py"):
        part = part_of(path)
        allowed = MAY_IMPORT.get(part)
        for name, line in imports(path):
            library = name.split(".")[0]
            where = f"{path}:{line}: {part} imports {library}"
            if library == NAME or library in sys.stdlib_module_names:
                continue
            assert allowed is None or library in allowed, where
            assert not is_ros(library) or part in ("nodes", "benchmarking", "commands"), where
            assert library not in OPTIONAL or part in ("detection", "training"), where
            assert library not in BLENDER or folder.name == "blender", where


def test_every_part_has_a_floor() -> None:
    parts = {part_of(path) for path in MODULES} - {"__init__"}
    assert parts == set(FLOOR)


LOAD_ALL = f"""
import importlib, pkgutil, sys
import {NAME}
class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {sorted(OPTIONAL | BLENDER | {"rclpy"})}:
            raise ImportError("refused by the test: " + name)
sys.meta_path.insert(0, Refuse())
loaded = 0
for module in pkgutil.walk_packages({NAME}.__path__, "{NAME}."):
    # What of benchmarking/ a command needs is loaded by it; the rest are programs with nodes. A
    # network's class is torch's; who trains one imports it, and says what is missing.
    using_torch = ("backbone", "second_look_network", "small_batch", "small_network")
    networks = tuple("{NAME}.training." + name for name in using_torch)
    left_out = ("{NAME}.nodes", "{NAME}.benchmarking", *networks)
    if not module.name.startswith(left_out):
        importlib.import_module(module.name)
        loaded += 1
print(loaded)
"""


def test_everything_but_the_nodes_loads_without_ros_and_optional_libraries() -> None:
    done = subprocess.run(
        [sys.executable, "-c", LOAD_ALL],
        cwd=PACKAGE.parent,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 40
