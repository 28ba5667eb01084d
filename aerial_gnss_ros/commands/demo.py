# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss demo`: a simulated flight through the real nodes, then map and report."""

from __future__ import annotations

import argparse
import itertools
import json
import math
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aerial_gnss_ros.adapters.canonical import detection_frame
from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.bags.reader import BagReader, open_bag
from aerial_gnss_ros.bags.replay import Replay
from aerial_gnss_ros.bags.results import ResultFolder
from aerial_gnss_ros.bags.tables import EstimatedTrack, Track, read_positions
from aerial_gnss_ros.bags.writer import BagWriter
from aerial_gnss_ros.commands.live_table import live_table
from aerial_gnss_ros.commands.notices import say
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.config.schema import flatten
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame, empty_detections
from aerial_gnss_ros.core.values.errors import ConfigError, RosError
from aerial_gnss_ros.detection.config import DetectorConfig, detector_config
from aerial_gnss_ros.detection.drawn_boxes import boxes_jpeg
from aerial_gnss_ros.detection.images import decode
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.evaluation.errors import RobotErrors, compare, distances, summarise
from aerial_gnss_ros.evaluation.platform import read_platform
from aerial_gnss_ros.evaluation.receiver import read_fixes, relative
from aerial_gnss_ros.evaluation.reference_effect import while_corrected
from aerial_gnss_ros.evaluation.report import Report, metres, write_report
from aerial_gnss_ros.evaluation.track_map import map_png
from aerial_gnss_ros.evaluation.truth import Truth, read_truth
from aerial_gnss_ros.nodes import require_ros
from aerial_gnss_ros.simulation.bag import DETECTIONS_TYPE, IMAGE_TOPICS, write_bag
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.scenario import scenario
from aerial_gnss_ros.simulation.scene import demo_scene
from aerial_gnss_ros.simulation.sensors import sensor_plan

if TYPE_CHECKING:
    from aerial_gnss_ros.nodes.live import Heard, LivePosition

SIMULATED = (
    "The images are simulated: sea and robots are rendered, sensor errors are random with the "
    "stated sigmas. Nodes, topics and transport are real."
)
WITHOUT = "without_reference"
LIVE = "filter, live: what the nodes published"
METHODS = {
    "filter": "filter, replayed: tracked over time",
    WITHOUT: "filter, replayed without the reference",
    "single": "single: exact ray, each image alone",
    "paper": "paper: the published equations, corrected",
}
RELATIVE = " (relative)"
RELATIVE_MEANS = (
    "Relative: without the error of the drone's own GNSS receiver, as the paper measures; "
    "nothing aboard can observe it."
)
IMAGES = "/" + IMAGE_TOPICS["jpeg"]
CAMERA = "/camera/camera_info"
PLAYED = (IMAGES, CAMERA, "/fix", "/attitude", "/gimbal", "/height")
NOISE = "consumer"
SURVEY_M = 0.05  # how well the reference's position is known
REFERENCE = (
    "One robot stays at a place that is known to 5 cm: a reference. The others' positions refer to "
    "it (docs/howto/references.md); it is not counted in the errors."
)
SEARCH = {"search.mode": "roi"}  # searching whole images is too slow for real time on a CPU
_TRIED = 30  # images that measure the machine's speed
_BUSY = 0.6  # share of the time that detection may take; the rest is for other processes


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = SIMULATED
    parser.add_argument(
        "--duration",
        type=float,
        default=30.0,
        metavar="S",
        help="duration of the flight, s (default 30)",
    )
    parser.add_argument("--robots", type=int, default=3, metavar="N", help="default 3")
    parser.add_argument(
        "--drones", type=int, metavar="N",
        help="several drones over the same robots, 2 to 4: each alone and all together, from "
        "recordings (default: one drone, live)",
    )  # fmt: skip
    parser.add_argument(
        "--height",
        type=float,
        default=15.0,
        metavar="M",
        help="height above the water, m (default 15)",
    )
    parser.add_argument("--seed", type=int, default=1, help="random seed (default 1)")
    parser.add_argument(
        "-o", "--output", type=Path, default=Path(), metavar="DIR",
        help="folder for a new numbered folder (default: the working folder)",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print the figures as JSON")


def run(args: argparse.Namespace) -> int:
    """Simulate, fly, compare and report."""
    if args.drones is None:
        require_ros()
    elif not 2 <= args.drones <= 4:
        raise ConfigError(f"--drones must lie within 2 to 4, not {args.drones}.")
    if not 5.0 <= args.duration <= 600.0:
        raise ConfigError(f"--duration must lie within 5 to 600 s, not {args.duration:g}.")
    if not 1 <= args.robots <= 20:
        raise ConfigError(f"--robots must lie within 1 to 20, not {args.robots}.")
    if args.drones is not None:
        from aerial_gnss_ros.commands.demo_drones import demo_drones

        return demo_drones(args, numbered_folder(args.output))
    experiment = demo_experiment(args.duration, args.height, args.robots, args.seed)
    folder = numbered_folder(args.output)
    say(SIMULATED)
    say(REFERENCE)
    with progress("rendering the flight", len(experiment.frames()), "images") as report:
        about = scenario(experiment, NOISE)
        write_bag(folder / "flight", experiment, demo_scene(args.seed), scenario=about,
                  report=report)  # fmt: skip
    with open_bag(folder / "flight") as bag:
        truth = read_truth(bag)
        rate = _rate(bag)
    reference, known = experiment.swarm.names[0], flatten({"references": about["references"]})
    live = _fly(folder, truth, rate, known)
    with open_bag([folder / "flight", folder / "detections"]) as bag:
        results = {method: _replay(bag, method, folder, known) for method in METHODS}
        pictures = _pictures(bag)
        fixes = read_fixes(bag, "/fix")
    compared = {LIVE: live} | {METHODS[name]: found for name, (found, _) in results.items()}
    errors = _errors(compared, truth, fixes, reference)
    replay = results["filter"][1]
    (folder / "map.png").write_bytes(map_png(live, truth.robots, truth.drone))
    write_report(
        folder / "report.html",
        Report(
            "Demo: robots localised from a drone",
            [SIMULATED, REFERENCE, RELATIVE_MEANS, agreement(errors)],
            live, truth.robots, truth.drone, replay.summary.rejections, errors, pictures,
            [("flight", experiment.flight.words), ("sensor errors", NOISE),
             ("images", str(replay.summary.frames)), ("seed", str(args.seed))],
            platform=read_platform(folder / "filter" / "platform.csv"),
        ),
    )  # fmt: skip
    _show(folder, errors, as_json=args.json)
    return 0 if live else 1


def agreement(errors: Mapping[str, list[RobotErrors]]) -> str:
    """Return by how much live and replayed positions differ, in words."""
    apart = distances(errors[LIVE], errors[METHODS["filter"]])
    if not len(apart):
        return "No image has both a live and a replayed position."
    half, most = np.percentile(apart, (50, 95))
    return (
        f"Live and replayed positions of the same image differ by {half:.3f} m (median; 95 %: "
        f"{most:.3f} m): heights have no stamp and get that of their arrival."
    )


def demo_experiment(duration_s: float, height_m: float, robots: int, seed: int) -> Experiment:
    """Return the demo's flight: an orbit round some robots and one that stays.

    Args:
        duration_s: s.
        height_m: above the water, m.
        robots: that swim.
        seed: of all random numbers.
    """
    plan = FlightPlan("orbit", duration_s, height_m)
    return Experiment(
        GeneratedFlight(plan, seed), default_camera(1280, 720), sensor_plan(NOISE),
        robots=robots + 1, swim=SwimPlan(beacons=1, beacon_class=SwimPlan.class_name),
        survey_m=SURVEY_M, seed=seed,
    )  # fmt: skip


def numbered_folder(parent: Path) -> Path:
    """Make and return the first of demo_001, demo_002, … that does not exist."""
    parent.mkdir(parents=True, exist_ok=True)
    for number in itertools.count(1):
        folder = parent / f"demo_{number:03d}"
        try:
            folder.mkdir()
        except FileExistsError:
            continue
        return folder
    raise AssertionError


def _rate(bag: BagReader) -> float:
    """Return a playback rate with which this machine's detector keeps up; 1 is real time."""
    detector, seconds = load_detector(detector_config(SEARCH)), []
    for recorded in itertools.islice(bag.messages({IMAGES}), _TRIED):
        image = decode(recorded.message())
        began = time.perf_counter()
        detector.detect(image)
        seconds.append(time.perf_counter() - began)
    # The first images initialise the network, and are searched whole.
    each = float(np.percentile(seconds[_TRIED // 3 :], 90))
    rate = min(1.0, _BUSY / (each * CameraClock().rate_hz))
    if rate < 1.0:
        say(
            f"An image takes {1000.0 * each:.0f} ms here, too slow for {CameraClock().rate_hz:g} "
            f"images a second: the flight is played at {rate:.2f} of real time."
        )
    return rate


def _errors(
    tracks: Mapping[str, dict[str, EstimatedTrack]], truth: Truth, fixes: Track, reference: str
) -> dict[str, list[RobotErrors]]:
    """Return the errors of all robots but the reference, by what was compared, in words."""

    def compared(name: str, found: dict[str, EstimatedTrack]) -> list[RobotErrors]:
        drone = truth.drone if name == LIVE else None
        return [one for one in compare(found, truth.robots, drone) if one.truth_id != reference]

    errors: dict[str, list[RobotErrors]] = {}
    for name, found in tracks.items():
        errors[name] = compared(name, found)
        corrected, share = while_corrected(found, tracks[METHODS[WITHOUT]])
        if share > 0.0:
            words = f"{name.split(':')[0]}: {share:.0%} of images, with the reference"
            errors[words] = compared(name, corrected)
    if truth.drone is not None:
        for name in (METHODS[WITHOUT], METHODS["single"], METHODS["paper"]):
            errors[name + RELATIVE] = relative(errors[name], fixes, truth.drone)
    return errors


def _fly(
    folder: Path, truth: Truth, rate: float, known: Mapping[str, object]
) -> dict[str, EstimatedTrack]:
    """Play the flight into the nodes, keep the boxes, and return the published positions."""
    import rclpy

    from aerial_gnss_ros.nodes.live import fly
    from aerial_gnss_ros.nodes.transport import use_large_data_profile

    use_large_data_profile()
    rclpy.init()
    try:
        say(f"Starting detector and estimator (their log: {folder / 'nodes.log'}).")
        with (
            open_bag(folder / "flight") as bag,
            live_table(truth.robots, sys.stderr) as show,
        ):
            heard = fly(
                bag, list(PLAYED), folder / "nodes.log",
                lambda elapsed, positions: show(elapsed * rate, tracks(positions)), rate, SEARCH,
                known,
            )  # fmt: skip
    finally:
        rclpy.try_shutdown()
    if not heard.detections:
        raise RosError(
            f"no detections arrived; see {folder / 'nodes.log'}, and check that no firewall "
            "blocks communication between processes on this machine."
        )
    keep_boxes(folder, heard)
    say(f"{len(heard.detections)} of {heard.images} images passed through both nodes.")
    return tracks(heard.positions)


def keep_boxes(folder: Path, heard: Heard) -> None:
    """Write live boxes as a bag beside the flight, each at the time at which its image arrived.

    Written at the image's stamp, the first boxes would precede the camera's first CameraInfo, and a
    replay would refuse them.
    """
    with open_bag(folder / "flight") as bag:
        arrived_ns = {
            nanoseconds(one.message().header.stamp): one.log_ns for one in bag.messages({CAMERA})
        }
    with BagWriter(folder / "detections") as boxes:
        for stamp_ns, raw in heard.detections:
            boxes.write("detections", DETECTIONS_TYPE, arrived_ns.get(stamp_ns, stamp_ns), raw)


def tracks(positions: Mapping[str, Sequence[LivePosition]]) -> dict[str, EstimatedTrack]:
    """Return what was heard as tracks by robot id."""
    found = {}
    for name, heard in sorted(positions.items()):
        rows = list(heard)  # the subscriber's thread continues to append
        cov = np.array([row.covariance for row in rows])
        found[name] = EstimatedTrack(
            np.array([row.stamp_ns for row in rows], dtype=np.int64),
            np.radians([row.latitude_deg for row in rows]),
            np.radians([row.longitude_deg for row in rows]),
            cov[:, [0, 1, 1, 2]].reshape(-1, 2, 2),
            np.array([row.measured for row in rows]),
        )
    return found


def _replay(
    bag: BagReader, method: str, folder: Path, known: Mapping[str, object]
) -> tuple[dict[str, EstimatedTrack], Replay]:
    """Replay the flight and its live boxes with one method, into a separate folder."""
    stated = {} if method == WITHOUT else {**known, "method": method}
    config = estimator_config(stated)
    replay = Replay(bag, config, DetectorConfig(), load_detector)
    target = folder / method
    target.mkdir()
    with (
        ResultFolder(target, overview=replay.overview) as results,
        progress(f"replaying with method {method}", replay.message_count, "messages") as report,
    ):
        for result in replay.results(report):
            results.add(result)
    return read_positions(target / "positions.csv"), replay


def _pictures(bag: BagReader) -> list[tuple[str, bytes]]:
    """Return the image in the middle of the flight with its boxes."""
    found: dict[int, DetectionFrame] = {}
    for recorded in bag.messages({"/detections"}):
        frame = detection_frame(recorded.message())
        found[frame.stamp_ns] = frame
    wanted = sorted(found)[len(found) // 2]
    for recorded in bag.messages({IMAGES}):
        message = recorded.message()
        if nanoseconds(message.header.stamp) == wanted:
            boxes = found.get(wanted, empty_detections(wanted))
            return [("A rendered image with the detected boxes.",
                     boxes_jpeg(decode(message), boxes))]  # fmt: skip
    return []


def _show(folder: Path, errors: Mapping[str, list[RobotErrors]], *, as_json: bool) -> None:
    if as_json:
        figures: dict[str, Any] = {
            method: {
                "all": summarise(robots).figures(),
                "robots": {r.truth_id: summarise([r]).figures() for r in robots},
            }
            for method, robots in errors.items()
        }
        print(json.dumps({"output": str(folder), "errors": figures}, indent=2))
        return
    names = [robot.truth_id for robot in next(iter(errors.values()))]
    print("\nError against truth, median / p95 (m); simulated images")
    print(f"{'':<52}" + "".join(f"{name:>15}" for name in [*names, "all"]))
    for method, robots in errors.items():
        cells = [_cell([robot]) for robot in robots] + [_cell(robots)]
        print(f"{method:<52}" + "".join(f"{cell:>15}" for cell in cells))
    print(RELATIVE_MEANS)
    print(agreement(errors))
    print(f"\nmap:    {folder / 'map.png'}\nreport: {folder / 'report.html'}")


def _cell(robots: list[RobotErrors]) -> str:
    summary = summarise(robots)
    if math.isnan(summary.median):
        return "not found"
    return f"{metres(summary.median)} / {metres(summary.p95)}"
