# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Source files begin with whose they are and under which licence."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "tools" / "headers.py"
SPEC = importlib.util.spec_from_file_location("headers", SCRIPT)
headers = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(headers)

HEAD = headers.COPYRIGHT + headers.LICENCE


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ('"""Words."""\n', HEAD + '"""Words."""\n'),
        (headers.LICENCE + "x = 1\n", HEAD + "x = 1\n"),
        (HEAD + "x = 1\n", HEAD + "x = 1\n"),
        ("#!/usr/bin/env python3\nx = 1\n", "#!/usr/bin/env python3\n" + HEAD + "x = 1\n"),
        ("", HEAD),
    ],
)
def test_both_lines_stand_at_the_head_once(before, after):
    assert headers.headed(before) == after
    assert headers.headed(after) == after


def test_every_source_is_looked_at_and_nothing_that_was_built(tmp_path):
    for name in ("core/a.py", "build/b.py", "x.egg-info/c.py", "core/words.txt"):
        path = tmp_path / "aerial_gnss_ros" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    found = [path.relative_to(tmp_path).as_posix() for path in headers.sources(tmp_path)]
    assert found == ["setup.py", "aerial_gnss_ros/core/a.py"]


def test_all_sources_have_it():
    lacking = [path for path in headers.sources(headers.ROOT) if not _complete(path)]
    assert not lacking, "python tools/headers.py --write"


def _complete(path):
    text = path.read_text(encoding="utf-8")
    return text == headers.headed(text)
