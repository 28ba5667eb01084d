# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Markdown tables of the benchmarks: made, shown and kept."""

from __future__ import annotations

from pathlib import Path


def columns(heads: list[str], rows: list[list[str]]) -> str:
    """Return a Markdown table whose first column is of words, the others of numbers."""
    lines = [f"| {' | '.join(heads)} |", "|---" + "|---:" * (len(heads) - 1) + "|"]
    lines += [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join(lines) + "\n"


def show(table: str, path: Path | None) -> None:
    """Print a table, and keep it where the command line asks for it."""
    print(table)
    if path:
        path.write_text(table, encoding="utf-8")
