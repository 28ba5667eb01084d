# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The way of one image through the core: how many calls, and how often it changes files.

python benchmarks/one_image.py             # three robots
python benchmarks/one_image.py --files     # and the calls of each file

Counted is what one `Estimator.advance` calls inside the package for one image, after `--robots`
robots are tracked; the flight is that of scaling.py. A change is a call in another file than the
call before it; a return, a change to a file in which there was a call already. Equal on every
machine with the same version of Python. The first row counts every frame that Python's profiler
sees; the second one only functions with a name: comprehensions and generators, which Python
versions count differently, are left out. To compare another commit, copy this file into its
benchmarks/ and run it there.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from types import FrameType

import one_thread  # noqa: F401 - before numpy

# isort: split
from scaling import flight

import aerial_gnss_ros

PACKAGE = Path(aerial_gnss_ros.__file__).resolve().parent
Call = tuple[str, str]
"""File and function."""


def calls(work: Callable[[], object]) -> list[Call]:
    """Return the calls of Python functions of the package that some work makes, in order."""
    found: list[Call] = []
    root = str(PACKAGE) + "/"

    def note(frame: FrameType, event: str, _value: object) -> None:
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(root):
            found.append((code.co_filename[len(root) :], code.co_name))

    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(None)
    return found


@dataclass(frozen=True)
class Way:
    """Counts of a list of calls; see the module."""

    calls: int
    files: int
    changes: int
    returns: int

    @staticmethod
    def of(files: Sequence[str]) -> Way:
        """Return the counts of calls in these files, in order."""
        changes = sum(one != other for one, other in pairwise(files))
        distinct = len(set(files))
        return Way(len(files), distinct, changes, changes - max(0, distinct - 1))


def way(robots: int, images: int) -> list[Call]:
    """Return the calls for the last of so many images over so many robots.

    Raises:
        SystemExit: not all robots are tracked.
    """
    engine, shown = flight(robots, images)
    *before, (stamp_ns, boxes) = shown
    for earlier_ns, earlier in before:
        engine.add_detections(earlier)
        engine.advance(earlier_ns)
    engine.add_detections(boxes)
    done: list[int] = []
    found = calls(lambda: done.extend(len(one.estimates) for one in engine.advance(stamp_ns)))
    if done != [robots]:
        raise SystemExit(f"one image of {robots} robots was expected, not {done}.")
    return found


def main() -> int:
    """Count and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", type=int, default=3, help="tracked (default 3)")
    parser.add_argument("--images", type=int, default=60, help="the last is counted (default 60)")
    parser.add_argument("--files", action="store_true", help="list calls by file, too")
    given = parser.parse_args()
    every = way(given.robots, given.images)
    named = [call for call in every if not call[1].startswith("<")]
    print("| counted | calls | files | changes of file | returns |\n|---|---:|---:|---:|---:|")
    for words, some in (("every frame", every), ("functions with a name", named)):
        one = Way.of([file for file, _ in some])
        print(f"| {words} | {one.calls} | {one.files} | {one.changes} | {one.returns} |")
    if given.files:
        print("\n| file | calls |\n|---|---:|")
        for file, count in Counter(file for file, _ in every).most_common():
            print(f"| {file} | {count} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
