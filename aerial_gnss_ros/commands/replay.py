# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss replay`: localises the robots in recorded bags with the core that flies."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from aerial_gnss_ros.bags.drone_tables import read_drones
from aerial_gnss_ros.bags.partial import partial, refuse_existing
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.replay import Replay, Summary
from aerial_gnss_ros.bags.results import ResultFolder
from aerial_gnss_ros.bags.stated_datum import with_stated_datum
from aerial_gnss_ros.bags.tables import read_positions
from aerial_gnss_ros.commands import drone_arguments
from aerial_gnss_ros.commands.argument_types import add_rosbag_version
from aerial_gnss_ros.commands.configuration import add_arguments as add_configuration
from aerial_gnss_ros.commands.configuration import configuration
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.notices import say
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.commands.replay_summary import as_json, as_text, folded
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.position_updates import PositionUpdates
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.evaluation.errors import compare
from aerial_gnss_ros.evaluation.platform import read_platform
from aerial_gnss_ros.evaluation.report import Report, write_report
from aerial_gnss_ros.evaluation.truth import Truth, read_truth

if TYPE_CHECKING:
    from aerial_gnss_ros.bags.replay_drones import DronesReplay

HELP = "localise the robots in recorded bags"
_TRUTH_S = 0.09
"""Time between true positions that are read: interpolation errs by 1 mm at 1 m/s², s."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Recorded detections are used if the bag has them, unless --model is given; otherwise "
        "the detector searches the images. The same machine, versions and back end give the same "
        "bytes."
    )
    parser.add_argument(
        "bags", type=Path, nargs="*", metavar="BAG",
        help="rosbag2 folder, .mcap, .db3 or ROS 1 .bag; several if they belong together",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="new folder for the results"
    )
    add_rosbag_version(parser)
    parser.add_argument(
        "--each", action="store_true",
        help="each BAG is a flight of its own, with a result of its name in DIR",
    )  # fmt: skip
    parser.add_argument(
        "-j", "--jobs", type=int, metavar="N", help="with --each: flights at a time (default 1)"
    )
    parser.add_argument(
        "--no-bag", action="store_true", help="write no bag of the results, only tables: faster"
    )
    parser.add_argument(
        "--no-figures", action="store_true", help="a report without pictures: faster"
    )
    drone_arguments.add_arguments(parser.add_argument_group("several drones"))
    add_configuration(parser)
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")


def run(args: argparse.Namespace) -> int:
    """Replay bags."""
    drone_arguments.check(args)
    refuse_existing(args.output)
    if args.drone:
        return _replay_drones(args)
    if args.each:
        from aerial_gnss_ros.commands.replay_each import replay_each  # processes

        return replay_each(args, replay)
    if args.jobs is not None:
        raise ConfigError("-j has a meaning only with --each: one flight is replayed in order.")
    return replay(args)


def replay(args: argparse.Namespace) -> int:
    """Replay one flight."""
    config = configuration(args)
    with ended_cleanly(), open_bag(args.bags) as bag:
        flight = Replay(
            bag,
            with_stated_datum(config.estimator, bag),
            config.detector,
            load_detector,
            namespace=args.namespace,
            detect=args.model is not None,
        )
        say(f"Robots from {flight.summary.detections_from}; method {flight.method}.")
        with partial(args.output) as folder:
            folder.mkdir()
            with (
                _result_folder(folder, args, config.estimator, flight) as results,
                progress("replaying", flight.message_count, "messages") as report,
            ):
                for result in flight.results(report, results.add_detections):
                    results.add(result)
            truth = read_truth(bag, interval_s=_TRUTH_S)
            names = write_replay_report(folder, results, flight, truth, not args.no_figures)
    _conclude(args, flight.summary, names)
    return 0


def _replay_drones(args: argparse.Namespace) -> int:
    """Replay the flights of several drones into one result."""
    from aerial_gnss_ros.commands.replay_drones import replay_drones

    names: dict[str, str] = {}

    def finish(folder: Path, results: ResultFolder, replay: DronesReplay, truth: Truth) -> None:
        names.update(write_replay_report(folder, results, replay, truth, not args.no_figures))

    _conclude(args, replay_drones(args, load_detector, finish).summary, names)
    return 0


def _conclude(args: argparse.Namespace, summary: Summary, names: dict[str, str]) -> None:
    """Print notes and summary; `names` are the truth's by label."""
    for note in folded(summary.notes):
        say(note)
    if args.json:
        print(json.dumps(as_json(args.output, summary, names), indent=2))
    else:
        print(as_text(args.output, summary, names))


def load_detector(config: DetectorConfig) -> Detector:
    """Load the detector, with OpenCV, which recorded boxes do not need."""
    from aerial_gnss_ros.detection import select

    return select.load_detector(config)


def _result_folder(
    folder: Path, args: argparse.Namespace, config: EstimatorConfig, flight: Replay
) -> ResultFolder:
    updates = PositionUpdates(config.updates, config.noise.value("correlation_time_s"))
    return ResultFolder(
        folder,
        args.namespace,
        config.map,
        args.rosbag_version,
        updates,
        not args.no_bag,
        flight.overview,
    )


def write_replay_report(
    folder: Path,
    results: ResultFolder,
    replay: Replay | DronesReplay,
    truth: Truth,
    figures: bool = True,
) -> dict[str, str]:
    """Write report.html from the tables beside it, with errors if the bag has truth.

    Returns:
        The truth's names by published label; empty without truth.
    """
    summary = replay.summary
    estimates = read_positions(folder / "positions.csv")
    errors = {replay.method: compare(estimates, truth.robots)} if truth.robots else {}
    write_report(
        folder / "report.html",
        Report(
            title="Replay",
            notes=folded(summary.notes),
            estimates=estimates,
            truth=truth.robots,
            drone=results.drone,
            drones=read_drones(folder / "drones.csv"),
            rejections=summary.rejections,
            causes=summary.causes,
            methods=errors,
            platform=read_platform(folder / "platform.csv"),
            facts=[
                ("robots from", summary.detections_from),
                ("method", replay.method),
                ("images", str(summary.frames)),
                ("boxes", f"{summary.boxes}, of which {summary.used} updated robots"),
            ],
        ),
        None if figures else (),
    )
    return {one.robot_id: one.truth_id for one in errors.get(replay.method, []) if one.robot_id}
