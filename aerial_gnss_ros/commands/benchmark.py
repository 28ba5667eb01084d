# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss benchmark`: the paper's hardware test on this machine."""

from __future__ import annotations

import argparse
import json
import os
import shlex
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aerial_gnss_ros import __version__
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.benchmarking.flight import HEIGHT_M, SECONDS, flight, render
from aerial_gnss_ros.benchmarking.machine import describe
from aerial_gnss_ros.commands.argument_types import size
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.detection.select import find_model, load_detector
from aerial_gnss_ros.nodes import require_ros

if TYPE_CHECKING:
    from aerial_gnss_ros.benchmarking.suite import Setting

SEARCHES = ("roi", "full", "tiles")
NODES, ALONE = "nodes", "one-process"
BEGIN, END = "<!-- benchmark -->", "<!-- end of benchmark -->"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "A short simulated flight is rendered for each number of robots and played forward and "
        "backward in turn with increasing stamps; --bag uses a recording instead."
    )
    add = parser.add_argument
    add("--frames", type=int, default=3000, metavar="N", help="images per run (default 3000)")
    add("--robots", type=int, nargs="+", default=[1, 3], metavar="N", help="default 1 3")
    add(
        "--search",
        nargs="+",
        choices=SEARCHES,
        default=["roi", "full"],
        help="search modes to measure (default roi full)",
    )
    add("--way", nargs="+", choices=(NODES, ALONE), default=[NODES, ALONE], help="default both")
    add(
        "--starts",
        type=int,
        default=5,
        metavar="N",
        help="number of starts of the nodes (default 5)",
    )
    add("--rate", type=float, default=30.0, metavar="HZ", help="image rate, Hz (default 30)")
    add("--size", type=size, default=(1280, 720), metavar="WxH", help="px (default 1280x720)")
    add("--bag", type=Path, help="play this rosbag2 instead of a simulated flight")
    add("--model", help="detection model (default: the shipped one)")
    add("--backend", help="inference back end (default: the fastest one installed)")
    add("--params", type=Path, nargs="+", default=[], metavar="YAML", help="parameter files")
    add("--compare", metavar="MODEL", help="also time ultralytics' predict with this model")
    add("--allow-pickle", action="store_true", help="trust the .pt file of --compare")
    add("--seed", type=int, default=1, help="random seed of the flights (default 1)")
    add(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help="folder for benchmark.json and benchmark.md",
    )
    add(
        "--page", type=Path, metavar="MD",
        help=f"insert the table into this file, between {BEGIN} and {END}",
    )  # fmt: skip
    add("--json", action="store_true", help="print JSON instead of Markdown")


def run(args: argparse.Namespace) -> int:
    """Measure, and print or write the figures.

    Raises:
        AerialGnssError: wrong arguments, an unusable recording or model, or no ROS.
    """
    require_ros()
    _check(args)
    os.environ.setdefault(
        "ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"
    )  # excludes other machines' topics
    from aerial_gnss_ros.benchmarking.figures import markdown
    from aerial_gnss_ros.benchmarking.suite import Setting, costs
    from aerial_gnss_ros.nodes.memory import keep_freed_memory

    keep_freed_memory()  # as the nodes do
    given = {"model": args.model, "backend": args.backend}
    setting = Setting(
        args.frames,
        args.rate,
        args.params,
        {key: word for key, word in given.items() if word},
        args.starts,
    )
    for search in args.search:
        load_detector(setting.detector(mode=search))  # report an unusable detector before rendering
    figures: dict[str, Any] = {
        "when": time.strftime("%Y-%m-%d"),
        "command": shlex.join(["aerial-gnss", *sys.argv[1:]]),
        "version": __version__,
        "machine": describe(),
        "load_average_before": round(os.getloadavg()[0], 2),
        "images": _images_words(args),
        "runs": [],
    }
    with ended_cleanly(), tempfile.TemporaryDirectory(prefix="benchmark_") as folder:
        for robots in [None] if args.bag else sorted(set(args.robots)):
            with _recording(args, robots, Path(folder)) as bag:
                _measure(args, setting, bag, robots, figures)
    figures["cost_of_a_robot"] = costs(figures["runs"])
    text = markdown(figures)
    _write(args, figures, text)
    print(json.dumps(figures, indent=2) if args.json else text)
    return 0


def _check(args: argparse.Namespace) -> None:
    for name, value, low, high in (
        ("--frames", args.frames, 10, 100_000),
        ("--starts", args.starts, 1, 100),
        ("--rate", args.rate, 1.0, 240.0),
        ("--robots", min(args.robots), 1, 20),
        ("--robots", max(args.robots), 1, 20),
    ):
        if not low <= value <= high:
            raise ConfigError(f"{name} must lie within {low:g} to {high:g}, not {value:g}.")
    if args.page is not None:
        _split_page(args.page)
    if args.compare is not None:  # it would be needed only after half an hour
        if not find_model(args.compare).is_file():
            raise ConfigError(
                f"--compare {args.compare} does not exist; give ultralytics' .pt file."
            )
        if args.compare.endswith(".pt") and not args.allow_pickle:
            raise ConfigError(
                f"--compare {args.compare} is a pickle, which can run any code when it is loaded; "
                "add --allow-pickle if you trust it."
            )


def _images_words(args: argparse.Namespace) -> str:
    if args.bag:
        return f"of {args.bag.name}, played forward and backward in turn"
    width, height = args.size
    return (
        f"{width}x{height}, simulated: an orbit {HEIGHT_M:g} m above the water, {SECONDS:g} s "
        f"played forward and backward in turn, seed {args.seed}; telemetry at 50 Hz without "
        "latency"
    )


@contextmanager
def _recording(args: argparse.Namespace, robots: int | None, folder: Path) -> Iterator[Path]:
    """Yield a recording; a rendered one is removed afterwards."""
    if robots is None:
        yield args.bag
        return
    bag = folder / f"robots_{robots}"
    experiment = flight(robots, args.size, args.seed)
    with progress(f"rendering, robots {robots}", len(experiment.frames()), "images") as report:
        render(experiment, bag, args.seed, report)
    yield bag
    shutil.rmtree(bag)


def _measure(
    args: argparse.Namespace, setting: Setting, path: Path, robots: int | None, figures: Any
) -> None:
    from aerial_gnss_ros.benchmarking.suite import Suite, try_comparison

    with open_bag([path]) as bag:
        who = "recording" if robots is None else f"robots {robots}"
        suite = Suite(setting, bag, lambda what, n: progress(f"{who}, {what}", n, "images"))
        for search in args.search:
            found: dict[str, Any] = {"robots": robots, "search": search}
            if ALONE in args.way:
                found["one_process"], found["detector"] = suite.one_process(search)
            if NODES in args.way:
                with tempfile.TemporaryDirectory(prefix="benchmark_") as folder:
                    found["nodes"] = suite.nodes(search, Path(folder))
            figures["runs"].append(found)
        figures["ultralytics"] = try_comparison(suite, args.compare, allow_pickle=args.allow_pickle)


def _write(args: argparse.Namespace, figures: dict[str, Any], text: str) -> None:
    if args.output is not None:
        args.output.mkdir(parents=True, exist_ok=True)
        _replace(args.output / "benchmark.json", json.dumps(figures, indent=2) + "\n")
        _replace(args.output / "benchmark.md", text)
    if args.page is not None:
        before, after = _split_page(args.page)
        _replace(args.page, f"{before}{BEGIN}\n{text}{END}{after}")


def _split_page(page: Path) -> tuple[str, str]:
    """Return the page before and after the table.

    Raises:
        ConfigError: the page is missing or has no markers for the table.
    """
    text = page.read_text(encoding="utf-8") if page.is_file() else ""
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ConfigError(
            f"--page {page} has no lines {BEGIN} and {END}; add them where the table belongs."
        )
    return before, after


def _replace(path: Path, text: str) -> None:
    part = path.with_name(path.name + ".part")
    part.write_text(text, encoding="utf-8")
    part.replace(path)
