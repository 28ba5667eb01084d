# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Benchmarks write their tables into the pages of results, each into its own place."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
import tables

PAGE = """\
# Turns

<!-- turns.py -->
old
<!-- end of turns.py -->

More.

<!-- turns.py --camera -->
<!-- end of turns.py --camera -->
"""


@pytest.fixture
def page(tmp_path: Path) -> Path:
    path = tmp_path / "page.md"
    path.write_text(PAGE)
    return path


def test_a_table_replaces_the_one_before_and_says_how_it_was_made(page, monkeypatch) -> None:
    monkeypatch.setattr(sys, "argv", ["benchmarks/turns.py", "--flights", "hover 30"])
    tables.keep("| new |\n", page)
    text = page.read_text()
    assert "old" not in text
    assert "\n    python benchmarks/turns.py --flights 'hover 30'\n\n| new |\n<!-- end of" in text
    assert f", version {tables.__version__}:\n" in text
    assert text.startswith("# Turns\n\n<!-- turns.py -->\nMeasured 2")
    assert text.endswith(PAGE[PAGE.index("\n\nMore.") :])


def test_a_place_with_options_takes_what_they_measure(page, monkeypatch) -> None:
    monkeypatch.setattr(sys, "argv", ["benchmarks/turns.py", "--camera"])
    tables.keep("| new |\n", page)
    text = page.read_text()
    assert "\nold\n" in text
    assert text.index("| new |") > text.index("<!-- turns.py --camera -->")


def test_another_program_writes_a_file_of_its_own(page, monkeypatch) -> None:
    monkeypatch.setattr(sys, "argv", ["benchmarks/identity.py"])
    tables.keep("| new |\n", page)
    assert page.read_text() == "| new |\n"


def test_a_place_without_an_end_is_an_error(page, monkeypatch) -> None:
    monkeypatch.setattr(sys, "argv", ["turns.py"])
    page.write_text("<!-- turns.py -->\nold\n")
    with pytest.raises(ValueError, match="no <!-- end"):
        tables.keep("| new |\n", page)
