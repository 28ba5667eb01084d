# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every `aerial-gnss` command that README and documentation print is understood as printed.

Only parsed: most need a recording, a drone or minutes.
"""

from __future__ import annotations

import argparse
import importlib
import re
import shlex
from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest

from aerial_gnss_ros.cli import COMMANDS

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
GENERATED = ("commands.md", "files.md", "parameters.md", "topics.md")


def _blocks(page: Path) -> list[list[str]]:
    """Return the printed commands of each code block, continued lines joined."""
    blocks: list[list[str]] = [[]]
    for line in page.read_text(encoding="utf-8").replace("\\\n", " ").splitlines():
        text = line.removeprefix("$ ").strip()
        if line.startswith(("    ", "$ ", "aerial-gnss")) and text.startswith("aerial-gnss "):
            blocks[-1].append(text)
        elif not line.startswith("    ") and blocks[-1]:
            blocks.append([])
    return [block for block in blocks if block]


PRINTED = [
    (page, block)
    for page in PAGES
    if page.name not in GENERATED
    for block in _blocks(page)
]  # fmt: skip


def _words(command: str) -> list[str]:
    """Return a command's arguments; a loop's variable stands for a number."""
    return shlex.split(re.sub(r"\$\w+", "1", re.split(r"\s[#|>;]", command)[0]))[1:]


@pytest.mark.parametrize(("page", "block"), PRINTED, ids=lambda one: getattr(one, "name", ""))
def test_a_printed_command_is_understood(
    page: Path, block: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    for command in block:
        name, *arguments = _words(command)
        if name.startswith("-"):
            continue
        parser = argparse.ArgumentParser(prog=f"aerial-gnss {name}")
        importlib.import_module(f"aerial_gnss_ros.commands.{COMMANDS[name][0]}").add_arguments(
            parser
        )
        status = _status(parser, arguments)
        assert not status, f"{page.name}: {command}: {capsys.readouterr().err}"


def _status(parser: argparse.ArgumentParser, arguments: list[str]) -> object:
    try:
        parser.parse_args(arguments)
    except SystemExit as stop:
        return stop.code
    return 0


@pytest.mark.parametrize(("page", "block"), PRINTED, ids=lambda one: getattr(one, "name", ""))
def test_no_two_commands_of_a_block_write_the_same_result(page: Path, block: list[str]) -> None:
    written: Counter[str] = Counter()
    for command in block:
        words = _words(command)
        written.update(b for a, b in pairwise(words) if a in ("-o", "--output"))
    assert not [name for name, count in written.items() if count > 1], page.name


def test_commands_are_found() -> None:
    assert sum(len(block) for _, block in PRINTED) > 40
