# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The time of an image compared with that of another version of the program, in turns.

git worktree add --detach ../before COMMIT
python benchmarks/against.py ../before

Each version runs in a process of its own, imports the package and the flight of `scaling.py` from
its own folder, and works on a few images of its flight at a time, in turns with the other one and
on the same core: what else the machine does slows both down alike. A ratio is that of the median
processor times of two turns next to each other. With `--unprotected` this version works without the
parts that `safety_cost.py` leaves out: what the rest of it costs beside a version without them.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

HERE = Path(__file__).resolve().parents[1]
COUNTS = (3, 30, 100)
IMAGES = 8
"""Images of one turn."""
FIRST = 5
"""Turns of each version before those that count: robots are confirmed, caches fill."""
MOST = 65
"""Turns of one flight: telemetry is kept for 60 s, which are 600 images."""


@dataclass(frozen=True)
class Ratio:
    """Comparison for one number of robots.

    Attributes:
        robots: in view.
        this_us: median time of an image, µs.
        other_us: likewise, of the other version.
        ratio: of the first to the second, median over turns.
        low: its lower quartile.
        high: its upper quartile.
    """

    robots: int
    this_us: float
    other_us: float
    ratio: float
    low: float
    high: float

    @staticmethod
    def of(robots: int, times: list[tuple[float, float]]) -> Ratio:
        """Return the comparison of the times of both versions in each turn, µs."""
        ratios = sorted(this / other for this, other in times)
        this_us, other_us = (sorted(one)[len(times) // 2] for one in zip(*times, strict=True))
        low, middle, high = (ratios[k * len(ratios) // 4] for k in (1, 2, 3))
        return Ratio(robots, this_us, other_us, middle, low, high)


class Version:
    """A process that measures turns of one version.

    Args:
        tree: folder of the version.
        robots: in view.
        turns: that it has images for.
        options: of its process.
    """

    def __init__(self, tree: Path, robots: int, turns: int, options: tuple[str, ...] = ()) -> None:
        self._tree = tree
        self._process = subprocess.Popen(  # noqa: S603 - this program
            [sys.executable, __file__, "--work", str(robots), str(turns * IMAGES), *options],
            cwd=tree, env=os.environ | {"PYTHONPATH": str(tree)}, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip

    def turn(self) -> float:
        """Return the median processor time of an image in the next turn, µs.

        Raises:
            SystemExit: the process ended.
        """
        told, answer = self._process.stdin, self._process.stdout
        assert told is not None  # noqa: S101 - a pipe was asked for
        assert answer is not None  # noqa: S101 - likewise
        try:
            print(file=told, flush=True)
            return float(answer.readline())
        except (OSError, ValueError):
            raise SystemExit(f"{self._tree} cannot be measured: see its error above.") from None

    def end(self) -> None:
        """End the process."""
        self._process.communicate()


def compared(
    this: Path, other: Path, robots: int, turns: int, options: tuple[str, ...] = ()
) -> Ratio:
    """Measure two versions in turns; which is first changes from turn to turn.

    Args:
        this: folder of a version.
        other: likewise.
        robots: in view.
        turns: of each version.
        options: of the first version's process.
    """
    times: list[tuple[float, float]] = []
    while len(times) < turns:
        now = min(turns - len(times), MOST)
        one = Version(this, robots, now + FIRST, options)
        two = Version(other, robots, now + FIRST)
        found = [
            (one.turn(), two.turn()) if k % 2 else (two.turn(), one.turn())[::-1]
            for k in range(now + FIRST)
        ]
        times += found[FIRST:]
        one.end()
        two.end()
    return Ratio.of(robots, times)


def table(rows: list[Ratio]) -> str:
    """Return the comparisons as a table."""
    lines = ["| robots | µs an image | before | ratio | quartiles |", "|---:|---:|---:|---:|---:|"]
    lines += [
        f"| {one.robots} | {one.this_us:.0f} | {one.other_us:.0f} | {one.ratio:.2f} "
        f"| {one.low:.2f} to {one.high:.2f} |"
        for one in rows
    ]
    return "\n".join(lines) + "\n"


def work(robots: int, images: int, *, unprotected: bool = False) -> None:
    """Fly; for each line of the input work on a turn's images and print their median time, µs."""
    if hasattr(os, "sched_setaffinity"):  # both versions on one core: another may be busier
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    sys.path[0] = "benchmarks"  # of the version
    import scaling

    with contextlib.ExitStack() as until_the_end:
        if unprotected:
            import safety_cost

            until_the_end.enter_context(safety_cost.left_out(tuple(safety_cost.PARTS)))
        engine, shown = scaling.flight(robots, images)
        left = iter(shown)
        for _ in sys.stdin:
            spent: list[int] = []
            for _, (stamp_ns, boxes) in zip(range(IMAGES), left, strict=False):
                engine.add_detections(boxes)
                began = time.process_time_ns()
                engine.advance(stamp_ns)
                spent.append(time.process_time_ns() - began)
            print(1e-3 * sorted(spent)[len(spent) // 2], flush=True)


def main() -> int:
    """Measure and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tree", type=Path, help="folder of the other version")
    parser.add_argument("--turns", type=int, default=120, help="of each version (default 120)")
    parser.add_argument("--robots", type=int, nargs="+", default=COUNTS, help="default 3 30 100")
    parser.add_argument(
        "--unprotected", action="store_true", help="this version without its protection"
    )
    given = parser.parse_args()
    options = ("--unprotected",) if given.unprotected else ()
    if not (given.tree / "benchmarks" / "scaling.py").is_file():
        parser.error(f"{given.tree} has no benchmarks/scaling.py: it is no version of the program")
    other = given.tree.resolve()
    rows = [compared(HERE, other, one, given.turns, options) for one in given.robots]
    print(table(rows))
    return 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--work"]:
        work(int(sys.argv[2]), int(sys.argv[3]), unprotected="--unprotected" in sys.argv)
    else:
        sys.exit(main())
