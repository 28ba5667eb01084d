# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The generated reference names everything that a user can set, start, subscribe to or read."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from aerial_gnss_ros.cli import COMMANDS
from aerial_gnss_ros.core.config.schema import leaves
from aerial_gnss_ros.core.values.rejection import Cause, Reason
from aerial_gnss_ros.nodes.schemas import SCHEMAS

SCRIPT = Path(__file__).resolve().parents[2] / "tools" / "reference_pages.py"
SPEC = importlib.util.spec_from_file_location("reference_pages", SCRIPT)
reference_pages = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(reference_pages)


@pytest.mark.parametrize("node", SCHEMAS)
def test_every_parameter_has_a_row_with_its_default(node: str) -> None:
    page = reference_pages.parameters()
    for leaf in leaves(SCHEMAS[node]):
        default = reference_pages.scalar(leaf.default)
        assert f"| `{leaf.name}` | `{default}` |" in page


def test_every_command_is_there_with_its_options() -> None:
    page = reference_pages.commands()
    for name in COMMANDS:
        assert f"\n## {name}\n" in page
        assert f"usage: aerial-gnss {name} " in page


def test_every_topic_has_a_meaning() -> None:
    page = reference_pages.topics()
    for name in (*reference_pages.INPUTS, *reference_pages.OUTPUTS):
        described = {**reference_pages.INPUTS, **reference_pages.OUTPUTS}[name]
        assert f"| {described} |" in page, f"{name} is described, but no node knows it"


def test_a_topic_without_a_meaning_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(reference_pages.OUTPUTS, "map_datum")
    with pytest.raises(KeyError, match="map_datum"):
        reference_pages.topics()


def test_every_reason_and_every_cause_is_explained() -> None:
    page = reference_pages.files()
    for word in (*Reason, *Cause):
        assert f"| `{word}` | " in page


def test_pages_are_written_once(tmp_path: Path) -> None:
    reference_pages.write(tmp_path)
    before = {path.name: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    assert set(before) == set(reference_pages.PAGES)
    reference_pages.write(tmp_path)
    assert before == {path.name: path.stat().st_mtime_ns for path in tmp_path.iterdir()}


@pytest.mark.parametrize("name", sorted({*reference_pages.PAGES} - {"commands.md"}))
def test_the_pages_in_the_repository_are_those_of_the_code(name: str) -> None:
    page = SCRIPT.parent.parent / "docs" / "reference" / name
    of_code = reference_pages.wrapped(reference_pages.PAGES[name]())
    assert page.read_text(encoding="utf-8") == of_code, (
        f"python tools/reference_pages.py {page.parent}"
    )


def test_text_is_shown_as_it_is_and_code_as_code() -> None:
    assert reference_pages.escaped("a_b of `c_d`, [x|y]") == r"a\_b of `c_d`, \[x\|y]"


def test_noise_sets_have_their_figures() -> None:
    assert "| `noise.gnss_offset_m` | m | 1.2 | 0.02 |" in reference_pages.parameters()


def test_parameters_of_classes_and_robots_are_there() -> None:
    page = reference_pages.parameters()
    assert "| `classes.<name>.max_speed` | `.nan` | 0.01 to 50 m/s |" in page
    assert "\n### estimator: robots\n" in page
