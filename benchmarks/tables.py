# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Markdown tables of the benchmarks: made, shown, and written into the documentation.

A page under docs/results/ has places for measured text, each between two comments:

    <!-- glitches.py -->
    <!-- end of glitches.py -->

`--markdown PAGE` replaces what is between them, and says when, with which version and by which
command it was measured. A comment may name options as well (`<!-- runaway.py --camera -->`): it
takes only what a command with these options measures.
"""

from __future__ import annotations

import re
import shlex
import sys
import textwrap
from datetime import datetime, timezone
from pathlib import Path

from aerial_gnss_ros import __version__


def columns(heads: list[str], rows: list[list[str]]) -> str:
    """Return a Markdown table whose first column is of words, the others of numbers."""
    lines = [f"| {' | '.join(heads)} |", "|---" + "|---:" * (len(heads) - 1) + "|"]
    lines += [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join(lines) + "\n"


def show(table: str, path: Path | None) -> None:
    """Print a table, and keep it where the command line asks for it."""
    print(table)
    keep(table, path)


def keep(table: str, path: Path | None) -> None:
    """Write a table into its place on a page, or into a file of its own; nowhere without a path."""
    if path is None:
        return
    page = path.read_text(encoding="utf-8") if path.is_file() else ""
    place = _place(page, sys.argv)
    path.write_text(placed(page, place, table, sys.argv) if place else table, encoding="utf-8")


def _place(page: str, command: list[str]) -> str:
    """Return the words of the comment that takes what a command measures; empty without one."""
    program, given = Path(command[0]).name, set(command[1:])
    places = [
        words
        for words in re.findall(r"^<!-- (?!end of )(.*) -->$", page, flags=re.MULTILINE)
        if words.split()[0] == program and given >= set(words.split()[1:])
    ]
    return max(places, key=len, default="")


def placed(page: str, place: str, table: str, command: list[str]) -> str:
    """Return a page with a table in its place, beside the date, the version and the command.

    Raises:
        ValueError: the place has no end.
    """
    begin, end = f"<!-- {place} -->\n", f"<!-- end of {place} -->"
    before, _, rest = page.partition(begin)
    _, found, after = rest.partition(end)
    if not found:
        raise ValueError(f"the page has {begin.strip()} but no {end}")
    today = datetime.now(timezone.utc).date()
    words = ["python", f"benchmarks/{Path(command[0]).name}", *map(shlex.quote, command[1:])]
    lines = textwrap.wrap(" ".join(words), 110, break_long_words=False, break_on_hyphens=False)
    shown = " \\\n        ".join(lines)
    measured = f"Measured {today}, version {__version__}:\n\n    {shown}\n\n{table}"
    return f"{before}{begin}{measured}{end}{after}"
