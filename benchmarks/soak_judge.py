# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the minutes of a soak say: growth after the warm-up, restarts, wrong positions.

Fast DDS hands images over in a segment of shared memory that the camera's process makes, 33.6 MB
with the profile for images, and that every reader maps. Its pages count as a reader's memory from
when it first reads an image in them, and images come to lie in new ones while the reader lags
behind: so that count rises with the machine's load, up to the segment's size, for memory that is
there once. It is no growth of the node. What would be is more segments, such as those of processes
that are gone: their size is judged in its place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from statistics import median, quantiles
from typing import Any

WARM_UP = 0.1
"""Share of the minutes that do not count: buffers fill, and each kind of fault comes once."""

MOST_MB = 5.0
_JUDGED = (
    ("memory_mb", "memory", " MB", MOST_MB),
    ("segments_mb", "shared memory that it maps", " MB", MOST_MB),
    ("descriptors", "descriptors", "", 0.0),
    ("threads", "threads", "", 0.0),
)
"""Of each process: attribute of `Usage`, words, unit, the most that it may grow by."""

DELAY_FACTOR, DELAY_MS = 1.25, 2.0
"""How much longer the delay may be at the end than after the warm-up. The lower quartiles of the
minutes' medians are compared: what else runs on the machine only lengthens it, while a delay that
grows does so in the best minutes, too."""

WORK_FACTOR = 1.25
"""How much more processor time a position may take at the end: a delay that grows because there is
more to do shows here, whatever else the machine does."""


@dataclass
class Usage:
    """What a process holds.

    Attributes:
        pid: its number.
        memory_mb: resident, but for what is shared.
        descriptors: files and sockets.
        threads: their number.
        shared_mb: shared memory that it has touched.
        segments_mb: shared memory that it maps, the most that it can touch.
        processor_s: processor time since it was started; NaN: not told.
    """

    pid: int
    memory_mb: float
    descriptors: int
    threads: int
    shared_mb: float = 0.0
    segments_mb: float = 0.0
    processor_s: float = math.nan


@dataclass
class Minute:
    """What was seen in a minute.

    Attributes:
        fault: that was put in.
        usage: of each process, by its name.
        delay_ms: from an image's stamp to its positions at a subscriber: median, 95 of 100.
        control_ms: the same of what the camera publishes itself: what the machine adds.
        positions_hz: positions measured.
        wrong: of these, beyond 4 sigma and 5 m from every true robot.
        ended: sentences of the supervisor about ended processes, so far.
        provoked: processes killed on purpose, so far.
        load: processes that wait for a processor, mean of the minute.
    """

    fault: str
    usage: dict[str, Usage] = field(default_factory=dict)
    delay_ms: tuple[float, float] = (float("nan"), float("nan"))
    control_ms: tuple[float, float] = (float("nan"), float("nan"))
    positions_hz: float = 0.0
    wrong: int = 0
    ended: int = 0
    provoked: int = 0
    load: float = float("nan")


@dataclass(frozen=True)
class Finding:
    """One line of the verdict."""

    what: str
    value: str
    passed: bool


def verdict(minutes: Sequence[Minute]) -> list[Finding]:
    """Return what a soak of at least three minutes shows."""
    counted = minutes[max(1, round(WARM_UP * len(minutes))) :]
    if len(counted) < 2:
        raise ValueError("a soak of so few minutes says nothing")
    third = max(1, len(counted) // 3)
    first, last = counted[:third], counted[-third:]
    found = []
    for name in counted[0].usage:
        for field_name, what, unit, most in _JUDGED:
            before, after = (_typical(part, name, field_name) for part in (first, last))
            words = f"{before:.1f} to {after:.1f}{unit}"
            found.append(Finding(f"{name}: {what}", words, after - before <= most))
        before, after = (_work_ms(part, name) for part in (first, last))
        if not math.isnan(before + after):
            words = f"{before:.1f} to {after:.1f} ms"
            label = f"{name}: processor time a position"
            found.append(Finding(label, words, after <= WORK_FACTOR * before))
    before, after = (_best(part) for part in (first, last))
    allowed = DELAY_FACTOR * before + DELAY_MS
    words = f"{before:.1f} to {after:.1f} ms"
    found.append(Finding("delay, the best quarter of the minutes", words, after <= allowed))
    unprovoked = minutes[-1].ended - minutes[-1].provoked
    found.append(Finding("restarts not provoked", str(unprovoked), unprovoked == 0))
    wrong = sum(minute.wrong for minute in minutes)
    positions = 60.0 * sum(minute.positions_hz for minute in minutes)
    found.append(
        Finding("wrong positions", f"{wrong} of {positions:.0f}", wrong <= 0.001 * positions)
    )
    return found


def _typical(minutes: Sequence[Minute], name: str, what: str) -> float:
    return median(getattr(minute.usage[name], what) for minute in minutes if name in minute.usage)


def _work_ms(minutes: Sequence[Minute], name: str) -> float:
    """Return the median of the minutes' processor times a position, ms; NaN where none is known.

    A minute in which the process was started anew does not count.
    """
    spent = []
    for one, other in pairwise(minutes):
        before, after = one.usage.get(name), other.usage.get(name)
        if before and after and before.pid == after.pid and other.positions_hz:
            spent.append((after.processor_s - before.processor_s) / (60.0 * other.positions_hz))
    return 1e3 * median(spent) if spent else math.nan


def _best(minutes: Sequence[Minute]) -> float:
    """Return the lower quartile of the minutes' median delays, ms."""
    medians = sorted(minute.delay_ms[0] for minute in minutes)
    return medians[0] if len(medians) < 2 else quantiles(medians, n=4, method="inclusive")[0]


def minute_of(fields: dict[str, Any]) -> Minute:
    """Return a minute from what `dataclasses.asdict` made of it."""
    usage = {name: Usage(**used) for name, used in fields["usage"].items()}
    pairs = {name: tuple(fields[name]) for name in ("delay_ms", "control_ms")}
    return Minute(**{**fields, **pairs, "usage": usage})
