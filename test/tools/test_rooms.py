# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rooms and the imports between them are counted as they are."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))

from rooms import arrows, ground_up, modules


@pytest.fixture
def core(tmp_path):
    for name, text in {
        "low/__init__.py": '"""Low."""\n',
        "low/a.py": "A = 1\nB = 2\n",
        "high/b.py": "from aerial_gnss_ros.core.low.a import A, B\n",
        "high/c.py": "from aerial_gnss_ros.core.low import a\n"
        "from aerial_gnss_ros.core.low.a import A\nfrom aerial_gnss_ros.core.high.b import A\n",
    }.items():
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return tmp_path


def test_lines_of_modules_by_room(core):
    assert modules(core) == {"high": {"b": 1, "c": 3}, "low": {"a": 2}}


def test_a_module_counts_once_for_each_that_it_imports_from_another_room(core):
    assert arrows(core) == {("high", "low"): 2}


def test_rooms_stand_on_what_they_import():
    assert ground_up(["a", "b", "c"], Counter({("a", "b"): 1, ("b", "c"): 2})) == ["c", "b", "a"]
    with pytest.raises(ValueError, match=r"in a circle: a, b$"):
        ground_up(["a", "b", "c"], Counter({("a", "b"): 1, ("b", "a"): 1}))
