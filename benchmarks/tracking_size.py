# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How large tracking is: files, lines, and numbers that were chosen, by room.

python benchmarks/tracking_size.py                # this checkout
python benchmarks/tracking_size.py --root PATH    # another one
python benchmarks/tracking_size.py --list         # and each number with its value

A number counts if it is a constant of a module, NAMED_LIKE_THIS, or a field of a frozen dataclass
whose name ends in Tuning, and its value is made of numbers only: what is derived from another
constant does not count, nor do words and types. A room is a folder of core; as long as there is no
such folder, the files listed here stand for it.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
ROOMS = {
    "models": "joint_geometry joint_motion joint_platform pose_motion",
    "faults": "innovation_monitor turning turn_or_swim unexplained position_jumps manoeuvres "
    "standstill formation noise_level",
    "filter": "joint joint_state joint_update joint_view joint_groups joint_comparison "
    "latency_search latency_bank pose_lattice plausible_state",
    "association": "association candidates matching contested clutter track",
    "identity": "reacquisition whereabouts absences return_order pair doubts identity names "
    "saved_names encounters",
    "tracker": "tracks tracking naming pace account",
}
_NAME = re.compile(r"_?[A-Z][A-Z0-9_]*")
_LIBRARIES = {"math", "np", "numpy"}


@dataclass(frozen=True)
class Size:
    """Of a room.

    Attributes:
        files: its modules.
        lines: of these, all that there are.
        numbers: (file, name, value) of each chosen number.
    """

    files: int
    lines: int
    numbers: tuple[tuple[str, str, str], ...]


def files_of(core: Path, room: str) -> list[Path]:
    """Return the modules of a room."""
    if (core / room).is_dir():
        return sorted((core / room).rglob("*.py"))
    listed = [core / f"{name}.py" for name in ROOMS[room].split()]
    return [path for path in listed if path.exists()]


def size(paths: list[Path]) -> Size:
    """Return the size of some modules."""
    texts = {path.name: path.read_text(encoding="utf-8") for path in paths}
    lines = sum(len(text.splitlines()) for text in texts.values())
    numbers = [(name, *one) for name, text in texts.items() for one in chosen(text)]
    return Size(len(texts), lines, tuple(numbers))


def chosen(text: str) -> Iterator[tuple[str, str]]:
    """Yield name and value of each chosen number of a module's source."""
    for node in ast.parse(text).body:
        if isinstance(node, ast.ClassDef) and node.name.endswith("Tuning"):
            for field in node.body:
                if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
                    default = "" if field.value is None else ast.unparse(field.value)
                    yield f"{node.name}.{field.target.id}", default
        for name, value in _assigned(node):
            if _NAME.fullmatch(name) and _is_number(value):
                yield name, ast.unparse(value)


def _assigned(node: ast.stmt) -> Iterator[tuple[str, ast.expr]]:
    if isinstance(node, ast.AnnAssign) and node.value is not None:
        targets, value = [node.target], node.value
    elif isinstance(node, ast.Assign):
        targets, value = node.targets, node.value
    else:
        return
    for target in targets:
        if isinstance(target, ast.Name):
            yield target.id, value
        elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            for one, part in zip(target.elts, value.elts, strict=True):
                if isinstance(one, ast.Name):
                    yield one.id, part


def _is_number(value: ast.expr) -> bool:
    """Return whether a value is made of numbers only, math and numpy allowed."""
    names = {one.id for one in ast.walk(value) if isinstance(one, ast.Name)}
    constants = [one.value for one in ast.walk(value) if isinstance(one, ast.Constant)]
    return (
        names <= _LIBRARIES
        and bool(constants)
        and all(isinstance(one, int | float) for one in constants)
    )


def main() -> int:
    """Count and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", type=Path, default=HERE, help="of a checkout (default: this)")
    parser.add_argument("--list", action="store_true", help="each number with its value")
    given = parser.parse_args()
    core = given.root / "aerial_gnss_ros" / "core"
    if not core.is_dir():
        parser.error(f"there is no {core}; give the root of a checkout.")
    found = {room: size(files_of(core, room)) for room in ROOMS}
    print("| room | files | lines | numbers |\n|---|---:|---:|---:|")
    for room, one in found.items():
        print(f"| {room} | {one.files} | {one.lines} | {len(one.numbers)} |")
    every = list(found.values())
    lines, numbers = sum(one.lines for one in every), sum(len(one.numbers) for one in every)
    print(f"| together | {sum(one.files for one in every)} | {lines} | {numbers} |")
    if given.list:
        for room, one in found.items():
            print(
                *(f"{room}/{file}: {name} = {value}" for file, name, value in one.numbers), sep="\n"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
