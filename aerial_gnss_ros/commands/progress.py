# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Progress of long work on standard error: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

Report = Callable[[int], None]
"""Called with the amount done."""

PLAIN_LINES = 10
"""Approximate number of lines in a log file, however long the work takes."""


@contextmanager
def progress(
    what: str, total: int, unit: str = "", stream: TextIO | None = None
) -> Iterator[Report]:
    """Yield a function to call with the amount done.

    Args:
        what: name of the work, such as `rendering`.
        total: total amount; 0 if unknown.
        unit: of the amount, such as `images`.
        stream: output; None: standard error.
    """
    stream = sys.stderr if stream is None else stream
    if stream.isatty():
        with _bar(what, total, unit, stream) as report:
            yield report
    else:
        yield _lines(what, total, unit, stream)


@contextmanager
def _bar(what: str, total: int, unit: str, stream: TextIO) -> Iterator[Report]:
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn(unit),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(file=stream)) as bars:
        task = bars.add_task(what, total=total or None)
        yield lambda done: bars.update(task, completed=done)


def _lines(what: str, total: int, unit: str, stream: TextIO) -> Report:
    step = max(1, total // PLAIN_LINES) if total else 1000
    said = 0

    def report(done: int) -> None:
        nonlocal said
        if done // step > said // step or (done == total and said != total):
            of = f" of {total}" if total else ""
            stream.write(f"{what}: {done}{of} {unit}".rstrip() + "\n")
            stream.flush()
            said = done

    return report
