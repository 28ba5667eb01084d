# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Chosen numbers of tracking are fields that say what they are; one name means one thing."""

from __future__ import annotations

import ast
from collections import defaultdict
from pathlib import Path

import pytest

CORE = Path(__file__).resolve().parents[2] / "aerial_gnss_ros" / "core"
ROOMS = ("models", "faults", "filter", "association", "identity", "references", "tracker")
FIXED = {
    "CURRENT", "POSE_COUNT", "STEP_S", "STEP_NS", "VERSION", "_FORBIDDEN", "_MEDIAN", "_ENTRIES",
    "_CORRELATED", "EXPECTED",
}  # fmt: skip
"""Numbers that are no choice: dimensions, units, a format's version, mathematics."""

Field = tuple[str, str, str]
"""File, name and value."""


def modules() -> list[tuple[Path, ast.Module]]:
    paths = [path for room in ROOMS for path in sorted((CORE / room).glob("*.py"))]
    return [(path, ast.parse(path.read_text(encoding="utf-8"))) for path in paths]


def is_number(node: ast.expr) -> bool:
    names = {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
    constants = [one.value for one in ast.walk(node) if isinstance(one, ast.Constant)]
    plain = all(isinstance(one, int | float) and not isinstance(one, bool) for one in constants)
    return bool(constants) and plain and names <= {"math"}


def fields() -> list[Field]:
    found: list[Field] = []
    for path, tree in modules():
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and node.name.endswith("Tuning"):
                found += [
                    (path.stem, one.target.id, ast.unparse(one.value))
                    for one in node.body
                    if isinstance(one, ast.AnnAssign)
                    and isinstance(one.target, ast.Name)
                    and one.value is not None
                ]
    return found


def test_no_chosen_number_is_a_bare_constant():
    bare = [
        f"{path.stem}.{target.id}"
        for path, tree in modules()
        for node in tree.body
        if isinstance(node, ast.Assign) and is_number(node.value)
        for whole in node.targets
        for target in ast.walk(whole)
        if isinstance(target, ast.Name) and target.id.isupper() and target.id not in FIXED
    ]
    assert bare == []
    assert len(fields()) > 150


@pytest.mark.parametrize(
    ("path", "tree"), [pytest.param(*one, id=one[0].stem) for one in modules()]
)
def test_each_field_says_what_it_is(path, tree):
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and node.name.endswith("Tuning"):
            assert [ast.unparse(one) for one in node.decorator_list] == ["dataclass(frozen=True)"]
            body = node.body[1:]
            for one, after in zip(body[::2], body[1::2], strict=True):
                assert isinstance(one, ast.AnnAssign), f"{path.stem}: {ast.unparse(one)}"
                assert isinstance(after, ast.Expr)
                assert ast.unparse(after)[-2] == ".", f"{path.stem}: {ast.unparse(one)}"


def test_a_name_means_one_thing():
    values: dict[str, set[str]] = defaultdict(set)
    for _, name, value in fields():
        values[name].add(value)
    assert {name: sorted(each) for name, each in values.items() if len(each) > 1} == {}
