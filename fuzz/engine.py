# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Runs cases of a target, watches over each, and keeps what it did that it must not do.

A case is known by the seed, the target's name and its number: equal ones do the same. Cases come in
blocks. A block begins from a state of its own, and its cases follow one another, as faults do in a
flight; so a case is repeated by running its block up to it.
"""

from __future__ import annotations

import os
import random
import resource
import signal
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import Protocol

HANG_S = 5.0
"""A case may compute for so long, s of processor time: others may load the machine."""
STUCK_S = 60.0
"""A case may last so long, s of wall-clock time."""
MEMORY_BYTES = 256 * 2**20
"""A case may raise the greatest memory that the process ever held by so much."""
ADDRESS_BYTES = 8 * 2**30
"""Beyond this allocations fail, so that a runaway one ends as a finding, not the machine."""

EXCEPTION, GUARDED, HANG, NOT_FINITE, WRONG, MEMORY, OUTPUT = (
    "exception", "guarded", "hang", "non-finite", "wrong position", "memory", "bad output",
)  # fmt: skip
KINDS = (EXCEPTION, GUARDED, HANG, NOT_FINITE, WRONG, MEMORY, OUTPUT)
"""Guarded: the estimator caught an exception of its own, which is a fault all the same."""


class Broken(Exception):  # noqa: N818 - a finding, not an error of the fuzzer
    """A target's answer breaks a rule.

    Args:
        kind: one of KINDS.
        words: what it gave.
    """

    def __init__(self, kind: str, words: str) -> None:
        super().__init__(words)
        self.kind = kind


class _Hang(BaseException):
    """A case went on for too long; no handler of `Exception` swallows it."""


class Target(Protocol):
    """What is fuzzed.

    Attributes:
        name: as on the command line.
        weight: share of the cases.
        block: how many cases follow one another.
    """

    name: str
    weight: int
    block: int

    def begin(self, block: int, rng: random.Random) -> None:
        """Make the state in which a block of cases begins; after a finding, again."""

    def case(self, rng: random.Random, report: Callable[[str], None]) -> None:
        """Run one case; `report` takes in words what is done. Raises what should not be raised."""


@dataclass(frozen=True)
class Finding:
    """One case that broke a rule.

    Attributes:
        target: its name.
        case: its number.
        kind: one of KINDS.
        where: the last place in the program, or what was wrong: findings of one cause share it.
        words: what was done and what came of it.
        trace: of an exception.
    """

    target: str
    case: int
    kind: str
    where: str
    words: str
    trace: str = ""


@dataclass
class Tally:
    """What a target did.

    Attributes:
        cases: run.
        seconds: they lasted.
        findings: all of them.
    """

    cases: int = 0
    seconds: float = 0.0
    findings: list[Finding] = field(default_factory=list)

    def count(self, kind: str) -> int:
        """Return how many findings are of a kind."""
        return sum(finding.kind == kind for finding in self.findings)

    @property
    def causes(self) -> Counter[tuple[str, str]]:
        """How many findings share a kind and a place."""
        return Counter((finding.kind, finding.where) for finding in self.findings)


def run(
    target: Target,
    seed: int,
    first: int,
    count: int,
    show: Callable[[str], None] | None = None,
) -> Tally:
    """Run cases `first` to `first + count - 1`.

    Args:
        target: that is fuzzed.
        seed: of all chance.
        first: number of the first case.
        count: of cases.
        show: takes in words what is done, also by the cases of the block before the first.
    """
    tally = Tally()
    began = time.monotonic()
    start = first - first % target.block
    with _alarms(), _silent():
        for number in range(start, first + count):
            block = number // target.block
            if number == start or number % target.block == 0:
                target.begin(block, _generator(seed, target.name, f"block {block}"))
            wanted = number >= first
            finding = _one(target, seed, number, show)
            if finding is not None:
                target.begin(block, _generator(seed, target.name, f"block {block}"))
            if wanted:
                tally.cases += 1
                tally.findings += [finding] if finding else []
    tally.seconds = time.monotonic() - began
    return tally


def _one(
    target: Target, seed: int, number: int, show: Callable[[str], None] | None
) -> Finding | None:
    done: list[str] = []
    before = _peak()
    began = time.process_time()
    kind = where = words = trace = ""
    try:
        with _limited():
            target.case(_generator(seed, target.name, str(number)), done.append)
    except Broken as broken:
        kind, words = broken.kind, str(broken)
        where = words.split(":", 1)[0]
    except _Hang as hang:
        kind, where, words = HANG, place(hang), f"longer than {HANG_S:g} s in {place(hang)}"
    except Exception as error:  # noqa: BLE001 - whatever comes is what is looked for
        kind, where = EXCEPTION, f"{type(error).__name__} in {place(error)}"
        words = f"{where}: {str(error)[:200]}"
        trace = "".join(traceback.format_exception(error))
    grown = _peak() - before
    lasted = time.process_time() - began
    if not kind and grown > MEMORY_BYTES:
        kind, where, words = MEMORY, "memory", f"{grown / 2**20:.0f} MB more than ever before"
    if not kind and lasted > HANG_S:
        kind, where, words = HANG, "native code", f"{lasted:.1f} s"
    if show is not None:
        for line in done:
            show(f"{number}: {line}")
    if not kind:
        return None
    return Finding(target.name, number, kind, where, " | ".join([*done[:4], words]), trace)


def place(error: BaseException) -> str:
    """Return the innermost place of this program in a traceback, or the innermost at all."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if "aerial_gnss_ros" in Path(frame.filename).parts]
    last = (own or list(frames))[-1]
    name = Path(last.filename)
    return f"{name.parent.name}/{name.name}:{last.name}"


def _generator(seed: int, target: str, what: str) -> random.Random:
    return random.Random(f"{seed} {target} {what}")


def _peak() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


@contextmanager
def _alarms() -> Iterator[None]:
    """Let alarms raise, and allocations end somewhere."""

    def raise_hang(_number: int, _frame: FrameType | None) -> None:
        raise _Hang

    old = {number: signal.signal(number, raise_hang) for number in (signal.SIGPROF, signal.SIGALRM)}
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = ADDRESS_BYTES if hard == resource.RLIM_INFINITY else min(ADDRESS_BYTES, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
        for number, handler in old.items():
            signal.signal(number, handler)


@contextmanager
def _silent() -> Iterator[None]:
    """Drop what libraries in C say of damaged images: it goes past Python to standard error."""
    sys.stderr.flush()
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    os.close(nowhere)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


@contextmanager
def _limited() -> Iterator[None]:
    """Raise _Hang when a case goes on for too long."""
    signal.setitimer(signal.ITIMER_PROF, HANG_S)
    signal.setitimer(signal.ITIMER_REAL, STUCK_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
