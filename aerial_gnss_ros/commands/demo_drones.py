# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss demo --drones`: several drones over the same robots, each alone and all together."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from aerial_gnss_ros.bags.drone_tables import read_drones
from aerial_gnss_ros.bags.reader import BagReader, open_bag
from aerial_gnss_ros.bags.replay import Replay, no_detector
from aerial_gnss_ros.bags.replay_drones import DronesReplay
from aerial_gnss_ros.bags.results import ResultFolder
from aerial_gnss_ros.bags.tables import EstimatedTrack, read_positions
from aerial_gnss_ros.commands.notices import say
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.evaluation.errors import RobotErrors, compare, summarise
from aerial_gnss_ros.evaluation.platform import read_platform
from aerial_gnss_ros.evaluation.report import Report, metres, write_report
from aerial_gnss_ros.evaluation.track_map import map_png
from aerial_gnss_ros.evaluation.truth import Truth, read_truth
from aerial_gnss_ros.simulation.bag import write_bag
from aerial_gnss_ros.simulation.experiment import Experiment, default_camera
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.formation import Formation, together
from aerial_gnss_ros.simulation.scenario import scenario
from aerial_gnss_ros.simulation.sensors import sensor_plan
from aerial_gnss_ros.text.sentences import counted

NOISE = "rtk"
SIMULATED = (
    "The flight is simulated, without images: boxes are those of a simulated detector, sensor "
    "errors are random with the stated sigmas. Receivers have RTK; compasses, gimbals and heights "
    "do not, and a hover does not show their errors to a drone alone."
)
TOGETHER = "together"


def demo_drones(args: argparse.Namespace, folder: Path) -> int:
    """Simulate several drones, and compare each alone with all together.

    Args:
        args: of the demo, checked.
        folder: new, for all files.
    """
    say(SIMULATED)
    bags = _simulate(args, folder)
    config = estimator_config({"noise.set": NOISE, "fix.altitude_datum": "ellipsoid"})
    with ExitStack() as opened:
        readers = {name: opened.enter_context(open_bag([path])) for name, path in bags.items()}
        truth = read_truth(next(iter(readers.values())))
        joined = DronesReplay(
            readers, dict.fromkeys(readers, config), DetectorConfig(), no_detector
        )
        tracks = {TOGETHER: _replayed(joined, folder / TOGETHER, TOGETHER)}
        joined.tables.write(folder / TOGETHER)
        for name, bag in readers.items():
            tracks[f"{name} alone"] = _alone(name, bag, config, folder)
    errors = {name: compare(found, truth.robots) for name, found in tracks.items()}
    _report(args, folder, joined, tracks[TOGETHER], truth, errors)
    _show(folder, errors, as_json=args.json)
    return 0 if tracks[TOGETHER] else 1


def _simulate(args: argparse.Namespace, folder: Path) -> dict[str, Path]:
    """Return the bag of each drone."""
    plan = sensor_plan(NOISE)

    def first(flight: GeneratedFlight, others: Sequence[GeneratedFlight]) -> Experiment:
        return Experiment(
            flight, default_camera(1280, 720), plan, robots=args.robots, seed=args.seed,
            others=others,
        )  # fmt: skip

    made = together(
        first,
        FlightPlan("hover", args.duration, args.height),
        Formation("opposite", args.drones),
        args.seed,
        [plan] * args.drones,
    )
    for name, experiment in made.items():
        with progress(f"simulating drone {name}", len(experiment.frames()), "images") as report:
            about = scenario(experiment, NOISE)
            write_bag(folder / name, experiment, None, scenario=about, report=report)
    return {name: folder / name for name in made}


def _alone(
    name: str, bag: BagReader, config: EstimatorConfig, folder: Path
) -> dict[str, EstimatedTrack]:
    """Replay the recording of one drone by itself."""
    replay = Replay(bag, config, DetectorConfig(), no_detector)
    return _replayed(replay, folder / f"{name}_alone", f"{name} alone")


def _replayed(replay: Replay | DronesReplay, folder: Path, words: str) -> dict[str, EstimatedTrack]:
    """Replay into a new folder; return the positions."""
    folder.mkdir()
    count = replay.message_count
    with (
        ResultFolder(folder, with_bag=False) as results,
        progress(f"replaying {words}", count, "messages") as report,
    ):
        for result in replay.results(report):
            results.add(result)
    return read_positions(folder / "positions.csv")


def _report(
    args: argparse.Namespace,
    folder: Path,
    joined: DronesReplay,
    tracks: dict[str, EstimatedTrack],
    truth: Truth,
    errors: dict[str, list[RobotErrors]],
) -> None:
    drones = read_drones(folder / TOGETHER / "drones.csv")
    (folder / "map.png").write_bytes(map_png(tracks, truth.robots, None, drones))
    write_report(
        folder / "report.html",
        Report(
            f"Demo: {counted(args.drones, 'drone')} over the same robots",
            [SIMULATED, comparison(errors)], tracks, truth.robots, None,
            joined.summary.rejections, errors,
            facts=[("flight", f"hover, {args.height:g} m up, on opposite sides"),
                   ("sensor errors", NOISE), ("images", str(joined.summary.frames)),
                   ("seed", str(args.seed))],
            platform=read_platform(folder / TOGETHER / "platform.csv"),
            drones=drones,
        ),
    )  # fmt: skip


def comparison(errors: dict[str, list[RobotErrors]]) -> str:
    """Return a sentence that compares each drone alone with all together.

    Args:
        errors: of all together, then of each alone, by what was compared.
    """
    rms = {name: summarise(robots).rmse for name, robots in errors.items()}
    both = rms.pop(TOGETHER)
    alone = ", ".join(f"{name} {metres(one)} m" for name, one in rms.items())
    words = f"Root mean square error: {alone}, together {metres(both)} m"
    return f"{words}: the best one alone errs {min(rms.values()) / both:.1f} times as much."


def _show(folder: Path, errors: dict[str, list[RobotErrors]], *, as_json: bool) -> None:
    if as_json:
        figures = {name: summarise(robots).figures() for name, robots in errors.items()}
        print(json.dumps({"output": str(folder), "errors": figures}, indent=2))
        return
    names = [robot.truth_id for robot in next(iter(errors.values()))]
    print("\nRoot mean square error against truth (m); simulated boxes")
    print(f"{'':<14}" + "".join(f"{name:>10}" for name in [*names, "all"]))
    for method, robots in errors.items():
        cells = [metres(summarise([robot]).rmse) for robot in robots]
        cells.append(metres(summarise(robots).rmse))
        print(f"{method:<14}" + "".join(f"{cell:>10}" for cell in cells))
    print(comparison(errors))
    print(f"\nmap:    {folder / 'map.png'}\nreport: {folder / 'report.html'}")
