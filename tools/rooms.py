# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The rooms of the core: their modules with line counts, and how often each imports which other.

python tools/rooms.py [--root PATH]    # of this checkout, or of another one
"""

from __future__ import annotations

import argparse
import ast
from collections import Counter
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
CORE = "aerial_gnss_ros.core."


def modules(core: Path) -> dict[str, dict[str, int]]:
    """Return the lines of each module by room, both in alphabetical order."""
    rooms: dict[str, dict[str, int]] = {}
    for path in sorted(core.glob("*/*.py")):
        if path.name != "__init__.py":
            lines = len(path.read_text(encoding="utf-8").splitlines())
            rooms.setdefault(path.parent.name, {})[path.stem] = lines
    return rooms


def arrows(core: Path) -> Counter[tuple[str, str]]:
    """Return how many (module, imported module) there are from a room to another."""
    found = set()
    for path in core.glob("*/*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith(CORE):
                continue
            inside = (node.module or "").removeprefix(CORE).split(".")
            targets = [inside] if len(inside) > 1 else [[*inside, one.name] for one in node.names]
            found |= {(path.parent.name, path.stem, *target[:2]) for target in targets}
    return Counter((room, other) for room, _, other, _ in found if room != other)


def ground_up(rooms: list[str], found: Counter[tuple[str, str]]) -> list[str]:
    """Return the rooms so that each stands right after those that it imports.

    Raises:
        ValueError: rooms import one another in a circle.
    """
    order: list[str] = []

    def put(room: str, through: tuple[str, ...]) -> None:
        if room in through:
            circle = ", ".join(sorted(through[through.index(room) :]))
            raise ValueError(f"these rooms import one another in a circle: {circle}")
        if room not in order:
            for other in sorted(rooms):
                if found[room, other]:
                    put(other, (*through, room))
            order.append(room)

    for room in sorted(rooms):
        put(room, ())
    return order


def main() -> None:
    """Print tree and table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", type=Path, default=HERE, help="of the checkout")
    core = parser.parse_args().root / "aerial_gnss_ros" / "core"
    rooms, found = modules(core), arrows(core)
    order = ground_up(list(rooms), found)
    for room in order:
        names = ", ".join(f"{name} {lines}" for name, lines in rooms[room].items())
        print(f"{room}/ {sum(rooms[room].values())}: {names}")
    total = sum(map(sum, (one.values() for one in rooms.values())))
    print(f"together {sum(map(len, rooms.values()))} modules, {total} lines\n")
    print(f"| room imports | {' | '.join(order[:-1])} |\n|---|{'---:|' * (len(order) - 1)}")
    for room in order:
        print(f"| {room} | {' | '.join(str(found[room, one] or '') for one in order[:-1])} |")


if __name__ == "__main__":
    main()
