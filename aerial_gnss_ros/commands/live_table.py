# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Live table of robots and their errors on a terminal, plain lines elsewhere."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TextIO

import numpy as np

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.evaluation.errors import compare

Show = Callable[[float, Mapping[str, EstimatedTrack]], None]
COLUMNS = ("robot", "latitude", "longitude", "one sigma", "error")
_PLAIN_EVERY_S = 2.0


def rows(
    estimates: Mapping[str, EstimatedTrack], truth: Mapping[str, Track]
) -> list[tuple[str, ...]]:
    """Return a text row per robot: newest position, one sigma and error."""
    last = {
        errors.robot_id: float(errors.distance[-1])
        for errors in compare(estimates, truth)
        if len(errors.stamps_ns)
    }
    return [_row(name, track, last.get(name)) for name, track in sorted(estimates.items())]


def _row(name: str, track: EstimatedTrack, error: float | None) -> tuple[str, ...]:
    sigma = math.sqrt(float(np.trace(track.covariance[-1])) / 2.0)
    return (
        name,
        f"{math.degrees(track.latitude[-1]):.7f}",
        f"{math.degrees(track.longitude[-1]):.7f}",
        f"{sigma:.2f} m",
        "–" if error is None else f"{error:.2f} m",
    )


@contextmanager
def live_table(truth: Mapping[str, Track], stream: TextIO) -> Iterator[Show]:
    """Yield a function of the flight time in s and the positions published so far."""
    if stream.isatty():
        with _terminal(truth, stream) as show:
            yield show
    else:
        yield _plain(truth, stream)


def _plain(truth: Mapping[str, Track], stream: TextIO) -> Show:
    due_s = [0.0]

    def show(elapsed_s: float, estimates: Mapping[str, EstimatedTrack]) -> None:
        if elapsed_s < due_s[0]:
            return
        due_s[0] = elapsed_s + _PLAIN_EVERY_S
        lines = rows(estimates, truth)
        if not lines:
            print(f"{elapsed_s:5.1f} s  no robot yet", file=stream, flush=True)
        for name, latitude, longitude, sigma, error in lines:
            print(
                f"{elapsed_s:5.1f} s  {name:<8} {latitude} {longitude}  one sigma {sigma}  "
                f"error {error}",
                file=stream, flush=True,
            )  # fmt: skip

    return show


@contextmanager
def _terminal(truth: Mapping[str, Track], stream: TextIO) -> Iterator[Show]:
    from rich.console import Console
    from rich.live import Live
    from rich.table import Table

    with Live(console=Console(file=stream), auto_refresh=False) as live:

        def show(elapsed_s: float, estimates: Mapping[str, EstimatedTrack]) -> None:
            table = Table(title=f"robots at {elapsed_s:.0f} s (simulated images, real nodes)")
            for column in COLUMNS:
                table.add_column(column, justify="left" if column == "robot" else "right")
            for row in rows(estimates, truth):
                table.add_row(*row)
            live.update(table, refresh=True)

        yield show
