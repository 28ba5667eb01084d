# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What `aerial-gnss replay` costs beside the estimator's core. docs/results/speed.md.

python benchmarks/replaying.py --markdown docs/results/speed.md

A simulated flight of a minute over three robots, 30 images a second, boxes and telemetry; the bag
has truth as well, which each replay reads and compares with. Counted is the processor time of whole
processes, one thread each, start of Python included. Of several runs the cheapest counts: programs
that share the processor's caches only add to it.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import one_thread  # noqa: F401 - before numpy

BARE = ("--no-bag", "--no-figures")
WAYS = {"pictures and result bag off": BARE, "with pictures and result bag": ()}
PER_IMAGE_S, START_S = 0.0003, 1.0
ALLOWED = {"pictures and result bag off": 1.0, "with pictures and result bag": 2.0}
"""Multiples of the core's time, `PER_IMAGE_S` for each image and `START_S`."""
CORE = (
    "advance", "flush", "add_camera", "add_fix", "add_attitude", "add_gimbal", "add_height",
    "add_detections",
)  # fmt: skip


def replayed(bag: Path, output: Path, flags: list[str], parts: Path) -> int:
    """Replay in this process, and write processor times, s, at the start and in the core."""
    from aerial_gnss_ros.cli import main as command
    from aerial_gnss_ros.commands import replay  # noqa: F401 - what the command imports
    from aerial_gnss_ros.core.estimation.estimator import Estimator

    start_s, core_s = time.process_time(), 0.0

    def timed(method: Callable[..., Any]) -> Callable[..., Any]:
        def call(*given: Any, **named: Any) -> Any:
            nonlocal core_s
            began = time.process_time()
            try:
                return method(*given, **named)
            finally:
                core_s += time.process_time() - began

        return call

    for name in CORE:
        setattr(Estimator, name, timed(getattr(Estimator, name)))
    status = command(["replay", str(bag), "-o", str(output), *flags])
    parts.write_text(json.dumps({"start": start_s, "core": core_s}))
    return status


def measured(bag: Path, flags: tuple[str, ...], folder: Path) -> dict[str, float]:
    """Return a new process's times, s: `total`, and of it `start` and `core`; and its `images`."""
    with tempfile.TemporaryDirectory(dir=folder) as output:
        parts = Path(output) / "parts.json"
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(  # noqa: S603 - this program, or the command it measures
            [sys.executable, __file__, "--replay", str(bag), str(Path(output) / "result"),
             str(parts), "--", *flags, "--json"],
            check=True, stdout=(Path(output) / "summary.json").open("w"),
            stderr=subprocess.DEVNULL,
        )  # fmt: skip
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        summary = json.loads((Path(output) / "summary.json").read_text())
        times: dict[str, float] = json.loads(parts.read_text())
    total = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {**times, "total": total, "images": float(summary["frames"])}


def table(runs: dict[str, list[dict[str, float]]]) -> str:
    """Return the cheapest run of each way, beside what is allowed."""
    from tables import columns

    rows = []
    for way, several in runs.items():
        best = min(several, key=lambda one: one["total"] - one["core"])
        images = best["images"]
        rest = best["total"] - best["core"] - best["start"]
        allowed = ALLOWED[way] * (best["core"] + PER_IMAGE_S * images + START_S)
        rows.append(
            [
                way,
                f"{best['total']:.2f}",
                f"{best['core']:.2f}",
                f"{best['start']:.2f}",
                f"{1e3 * rest / images:.2f}",
                f"{allowed:.2f}",
                f"{best['total'] / allowed:.2f}",
            ]
        )
    images = next(iter(runs.values()))[0]["images"]
    count = len(next(iter(runs.values())))
    return f"{images:.0f} images, the cheapest of {count} runs.\n\n" + columns(
        ["replay", "whole, s", "of it core, s", "start, s", "rest, ms an image", "allowed, s",
         "of that"],
        rows,
    )  # fmt: skip


def main() -> int:
    """Simulate the flight, replay it several times and write the table."""
    if sys.argv[1:2] == ["--replay"]:
        bag, output, parts = map(Path, sys.argv[2:5])
        return replayed(bag, output, sys.argv[6:], parts)
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--runs", type=int, default=5, help="of each way (default 5)")
    parser.add_argument("--duration", type=float, default=60.0, help="of the flight, s (60)")
    parser.add_argument("--markdown", type=Path, help="page with a place for the table")
    given = parser.parse_args()
    from tables import show

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        subprocess.run(  # noqa: S603 - this program, or the command it measures
            [sys.executable, "-m", "aerial_gnss_ros.cli", "simulate", "--no-images", "--robots",
             "3", "--rate", "30", "--duration", str(given.duration), "-o", str(folder / "bag")],
            check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        runs: dict[str, list[dict[str, float]]] = {way: [] for way in WAYS}
        for _ in range(given.runs):
            for way, flags in WAYS.items():
                runs[way].append(measured(folder / "bag", flags, folder))
    show(table(runs), given.markdown)
    return 0


if __name__ == "__main__":
    sys.exit(main())
