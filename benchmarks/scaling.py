# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What an image costs the estimator's core, from 1 to 1,000 robots; publishing is not in it.

python benchmarks/scaling.py --json scaling.json --markdown scaling.md
python benchmarks/scaling.py --modules 1    # where an image of one robot spends its time

An orbit of 80 m height over still robots on a grid, all in view of a camera of 4K; no image is
rendered. Counted is the processor time of one core for pose, points on the water and tracking,
after the robots are confirmed. Programs that share its caches make it longer; how many functions an
image calls, Python's and C's, does not depend on them.
"""

from __future__ import annotations

import argparse
import cProfile
import json
import math
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from tables import show

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.simulation.experiment import (
    CameraClock,
    Experiment,
    default_camera,
)
from aerial_gnss_ros.simulation.feeding import feed
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import START_NS

STAGES = ("pose", "locate", "track")
COUNTS = (1, 3, 10, 30, 100, 300, 1000)
GRID_M = 1.8

Images = list[tuple[int, DetectionFrame]]
"""Stamps, ns, and boxes."""


def flight(robots: int, images: int) -> tuple[Estimator, Images]:
    """Return an estimator that has the telemetry of a whole flight, and the flight's images."""
    side = math.ceil(math.sqrt(robots))
    grid = GRID_M * (np.stack(np.meshgrid(*[np.arange(side)] * 2), axis=-1) - 0.5 * (side - 1))
    made = Experiment(
        GeneratedFlight(FlightPlan("orbit", images / 10.0, 80.0, speed_mps=5.0), 1),
        default_camera(3840, 2160), clock=CameraClock(10.0), places=grid.reshape(-1, 2)[:robots],
        swim=SwimPlan(0.0, 0.0, roam_m=1e3, apart_m=0.1), seed=1,
    )  # fmt: skip
    engine = Estimator(estimator_config({}))
    engine.add_camera(START_NS - 10_000_000_000, made.camera)
    feed(engine, made.sensors)
    return engine, [(frame.stamp_ns, boxes) for frame, _, boxes in made.detections()]


def measure(robots: int, images: int) -> dict[str, float]:
    """Return microseconds per image: median and 95th percentile."""
    engine, shown = flight(robots, images)
    found: list[float] = []
    parts: list[list[float]] = []
    *images_, last = shown
    for stamp_ns, boxes in images_:
        engine.add_detections(boxes)
        began = time.process_time_ns()
        done = engine.advance(stamp_ns)
        spent = 1e-3 * (time.process_time_ns() - began)
        found += [spent / len(done)] * len(done)
        parts += [[one.timings_ms[name] for name in STAGES] for one in done]
    engine.add_detections(last[1])
    done, calls = counted(lambda: engine.advance(last[0]))
    tracked = len(done[-1].estimates)
    total = np.array(found[len(found) // 3 :])
    share = np.median(parts[len(parts) // 3 :], axis=0)
    return {
        "robots": robots,
        "tracked": tracked,
        "images": len(total),
        "median_us": float(np.median(total)),
        "p95_us": float(np.percentile(total, 95)),
        "us_per_robot": float(np.median(total)) / robots,
        "calls": calls.total() / len(done),
        **{
            f"{name}_share": float(one)
            for name, one in zip(STAGES, share / share.sum(), strict=True)
        },
    }


def counted(work: Callable[[], list[FrameResult]]) -> tuple[list[FrameResult], Counter[str]]:
    """Return what some work returns, and by module how many functions of Python and C it called."""
    calls = Counter[str]()

    def count(frame: FrameType, event: str, _value: object) -> None:
        if event in ("call", "c_call"):
            calls[Path(frame.f_code.co_filename).stem] += 1

    sys.setprofile(count)
    try:
        found = work()
    finally:
        sys.setprofile(None)
    return found, calls


def modules(robots: int, images: int) -> str:
    """Return a table of calls and of the share of processor time by module, for an image.

    A module's share holds what it calls in C, such as numpy. The profiler adds to each function of
    Python, so that modules with many small ones look larger than they are.
    """
    engine, shown = flight(robots, images)
    profile = cProfile.Profile(time.thread_time, builtins=False)
    *images_, last = shown
    for i, (stamp_ns, boxes) in enumerate(images_):
        engine.add_detections(boxes)
        if i >= len(images_) // 3:
            profile.enable()
        engine.advance(stamp_ns)
        profile.disable()
    spent = Counter[str]()
    for entry in profile.getstats():
        if not isinstance(entry.code, str):
            spent[Path(entry.code.co_filename).stem] += entry.inlinetime
    engine.add_detections(last[1])
    _, calls = counted(lambda: engine.advance(last[0]))
    lines = ["| module | calls | share of the time |", "|---|---:|---:|"]
    for name, own in spent.most_common():
        lines.append(f"| {name} | {calls[name]} | {own / spent.total():.1%} |")
    return "\n".join(lines) + "\n"


def markdown(rows: list[dict[str, float]]) -> str:
    """Return the table."""
    lines = [
        "| robots | tracked | µs an image | p95 | µs a robot | calls | pose, points, tracks |",
        "|---:|---:|---:|---:|---:|---:|---:|",
    ]
    keys = ("median_us", "p95_us", "us_per_robot", "calls")
    for one in rows:
        cells = " | ".join(f"{one[key]:.0f}" for key in keys)
        shares = ", ".join(f"{one[f'{name}_share']:.0%}" for name in STAGES)
        lines.append(f"| {one['robots']:.0f} | {one['tracked']:.0f} | {cells} | {shares} |")
    return "\n".join(lines) + "\n"


def main() -> int:
    """Measure and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--images", type=int, default=60, help="of each flight (default 60)")
    parser.add_argument("--most", type=int, default=1000, help="robots (default 1000)")
    parser.add_argument("--modules", type=int, metavar="N", help="only show modules, N robots")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--markdown", type=Path)
    given = parser.parse_args()
    if given.modules:
        print(modules(given.modules, given.images))
        return 0
    rows = []
    for robots in COUNTS:
        if robots <= given.most:
            rows.append(measure(robots, given.images))
            print(markdown(rows).splitlines()[-1], file=sys.stderr, flush=True)
    show(markdown(rows), given.markdown)
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
