# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss evaluate`: errors of a replay's positions against truth; figures and a report."""

from __future__ import annotations

import argparse
import csv
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.bags.drone_tables import read_drones
from aerial_gnss_ros.bags.partial import partial, refuse_existing
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.replay import Replay
from aerial_gnss_ros.bags.tables import EstimatedTrack, read_positions, read_rejections
from aerial_gnss_ros.commands.configuration import add_arguments as add_configuration
from aerial_gnss_ros.commands.configuration import configuration
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.values.errors import ConfigError, InputError
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.evaluation.errors import RobotErrors, compare, refuse_strangers, summarise
from aerial_gnss_ros.evaluation.hover import (
    Hover,
    away_from,
    find_hovers,
    hover_truth,
    seen_from_above,
)
from aerial_gnss_ros.evaluation.identity import Identities, identities
from aerial_gnss_ros.evaluation.nadir import nearest_view
from aerial_gnss_ros.evaluation.platform import read_platform
from aerial_gnss_ros.evaluation.report import Report, draw, metres, write_report
from aerial_gnss_ros.evaluation.truth import Truth, read_truth, read_truth_csv
from aerial_gnss_ros.resources import install_hint
from aerial_gnss_ros.text.plain_text import spreadsheet_cell
from aerial_gnss_ros.text.sentences import counted

NADIR_DEG = 10.0
ERROR_COLUMNS = (
    "frame", "stamp_ns", "truth_id", "robot_id", "geodesic_m", "haversine_m", "latitude_error_m",
    "longitude_error_m", "nees", "sigma_m", "range_m",
)  # fmt: skip


@dataclass(frozen=True)
class _Found:
    """The truth for a comparison, and its source."""

    truth: Truth
    estimates: dict[str, EstimatedTrack]
    notes: list[str] = field(default_factory=list)
    hovers: list[Hover] = field(default_factory=list)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Truth is stamped with the scene's time and positions with the image's: --latency, or "
        "what a simulated bag states on truth/scenario, aligns them."
    )
    parser.add_argument("result", type=Path, metavar="RESULT", help="folder that replay wrote")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument(
        "--truth", type=Path, nargs="+", metavar="BAG|CSV",
        help="bag with truth/robots/<id>/fix, or CSV: stamp_ns, robot_id, latitude_deg, "
        "longitude_deg",
    )  # fmt: skip
    source.add_argument(
        "--hover", type=Path, nargs="+", metavar="BAG",
        help=
                "truth from the flight itself: a robot's position is measured while the camera "
                "looks straight down at it, as in the paper; errors are then relative to the "
                "drone's receiver",
    )  # fmt: skip
    source.add_argument(
        "--verify", type=Path, nargs="+", metavar="BAG",
        help=
                "truth from another drone's recording: while its camera looks straight down at a "
                "robot, its position of that robot; errors are then relative to its receiver",
    )  # fmt: skip
    parser.add_argument(
        "--latency", type=float, metavar="S",
        help="an image stamped t shows the scene at t - S (default: the bag's value, else 0)",
    )  # fmt: skip
    parser.add_argument(
        "--nadir-deg", type=float, metavar="DEG",
        help=
                "with --hover, --verify: greatest angle from the vertical that counts as straight "
                f"down, deg (default {NADIR_DEG:g})",
    )  # fmt: skip
    parser.add_argument(
        "--still", type=float, metavar="S",
        help=
                "with --hover: time before and after for which a robot counts as still, s "
                "(default: the whole flight)",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR",
        help="new folder for report.html, the figures as PNG, errors.csv and summary.json",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print the figures as JSON")
    add_configuration(
        parser.add_argument_group("vehicle profile, with --hover, --verify, as for replay")
    )


def run(args: argparse.Namespace) -> int:
    """Compare, print, and write the requested files."""
    _check(args)
    estimates = read_positions(args.result / "positions.csv")
    found = _source(args, estimates)
    truth = found.truth
    refuse_strangers(found.estimates, truth.robots)
    errors = compare(found.estimates, truth.robots, truth.drone)
    if args.truth is not None:
        found.notes.extend(_left_over(found.estimates, errors))
    # Truth from hovers has the tracker's labels, and only robots that were hovered over.
    identity = (
        None
        if args.truth is None
        else identities(found.estimates, truth.robots, errors, truth.in_view)
    )
    figures = _as_dict(errors, identity, found)
    if args.output is not None:
        with partial(args.output) as folder:
            folder.mkdir(parents=True)
            _write(folder, args, found, errors, identity, figures)
    if args.json:
        print(json.dumps(figures, indent=2))
    else:
        print(_as_text(errors, identity, found))
        if args.output is not None:
            print(f"report: {args.output / 'report.html'}")
        else:
            print("figures and a report: give -o DIR")
    return 0


def _check(args: argparse.Namespace) -> None:
    if args.output is not None:
        refuse_existing(args.output)
    if args.latency is not None and not abs(args.latency) <= 3.0:
        raise ConfigError(f"--latency must lie within -3 to 3 s, not {args.latency:g}.")
    if args.truth:
        for name in ("nadir_deg", "still", "params", "vehicle", "namespace", "method", "model"):
            if getattr(args, name) not in (None, [], ""):
                raise ConfigError(f"--{name.replace('_', '-')} applies only with --hover.")
    if args.verify and args.still is not None:
        raise ConfigError("--still applies only with --hover.")
    if args.nadir_deg is not None and not 0.5 <= args.nadir_deg <= 45.0:
        raise ConfigError(f"--nadir-deg must lie within 0.5 to 45, not {args.nadir_deg:g}.")
    if args.still is not None and not args.still >= 0.0:
        raise ConfigError(f"--still must not be negative, but is {args.still:g}.")


def _truth(args: argparse.Namespace) -> Truth:
    if len(args.truth) == 1 and args.truth[0].suffix.lower() == ".csv":
        truth = read_truth_csv(args.truth[0], args.latency or 0.0)
        why = "it has no rows."
    else:
        with open_bag(args.truth) as bag:
            truth = read_truth(bag, args.latency)
            why = (
                "no topic is named truth/robots/<id>/fix, or none has messages; it has "
                f"{', '.join(bag.topics) or 'no topics'}."
            )
    if not truth.robots:
        raise InputError(f"{', '.join(map(str, args.truth))} has no truth: {why}")
    return truth


def _source(args: argparse.Namespace, estimates: dict[str, EstimatedTrack]) -> _Found:
    """Return the truth that the arguments name."""
    if args.hover:
        return _hovers(args, estimates)
    if args.verify:
        return _verified(args, estimates)
    return _Found(_truth(args), estimates)


def _looks_down(
    args: argparse.Namespace, bags: list[Path]
) -> tuple[list[FrameResult], Truth, float]:
    """Return a recording's results image by image, its truth, and the angle of `--nadir-deg`, rad.

    Raises:
        InputError: its camera never looks down.
    """
    config = configuration(args)
    single = replace(config.estimator, method="single")
    with open_bag(bags) as bag:
        nadir_deg = NADIR_DEG if args.nadir_deg is None else args.nadir_deg
        _refuse_without_a_look_down(nearest_view(bag, single, args.namespace), nadir_deg)
        flown = read_truth(bag, args.latency)
        replay = Replay(
            bag, single, config.detector, load_detector, namespace=args.namespace,
            detect=args.model is not None,
        )  # fmt: skip
        with progress("searching for hovers", replay.message_count, "messages") as report:
            return list(replay.results(report)), flown, math.radians(nadir_deg)


def _verified(args: argparse.Namespace, estimates: dict[str, EstimatedTrack]) -> _Found:
    results, flown, nadir = _looks_down(args, args.verify)
    robots = seen_from_above(results, nadir, flown.latency_s)
    count = sum(map(len, robots.values()))
    note = (
        f"Truth is taken from another drone: {counted(count, 'position')} of "
        f"{counted(len(robots), 'robot')} that it saw straight below it. Errors are relative to "
        "its receiver, whose offset NEES does not contain."
    )
    return _Found(Truth(robots, None, flown.latency_s), estimates, [note])


def _hovers(args: argparse.Namespace, estimates: dict[str, EstimatedTrack]) -> _Found:
    results, flown, nadir = _looks_down(args, args.hover)
    hovers = find_hovers(results, nadir)
    stamps = np.array([result.stamp_ns for result in results], dtype=np.int64)
    robots = hover_truth(hovers, stamps, args.still)
    note = (
        "Truth is taken from hovers over the robots, with the drone's own receiver: errors are "
        "relative to it, its offset cancels, and because the published covariance contains it, "
        "NEES is small. Images during the hovers are left out."
    )
    notes = [note]
    notes += [
        f"{h.robot}: {(h.end_ns - h.start_ns) * 1e-9:.1f} s of hover; {h.count} images agree "
        f"within {h.spread_m:.2f} m."
        for h in hovers
    ]
    still = "the whole flight" if args.still is None else f"{args.still:g} s before and after"
    notes.append(f"Each robot counts as still for {still}.")
    truth = Truth(robots, flown.drone, flown.latency_s)
    return _Found(truth, away_from(hovers, estimates), notes, hovers)


def _refuse_without_a_look_down(nearest: float, nadir_deg: float) -> None:
    """Refuse a flight without any view straight down, before its images are processed.

    Args:
        nearest: least angle between straight down and any line of sight in the images, rad; NaN:
            unknown.
        nadir_deg: greatest angle from the vertical, deg.

    Raises:
        InputError: the camera never looked down.
    """
    if math.degrees(nearest) > nadir_deg:
        raise InputError(
            f"there is no hover: every line of sight is {math.degrees(nearest):.1f} deg or more "
            f"from straight down, and at most {nadir_deg:g} deg counts; give --truth, or a wider "
            "--nadir-deg."
        )


def _left_over(estimates: Mapping[str, EstimatedTrack], errors: Sequence[RobotErrors]) -> list[str]:
    """Return a sentence about published robots that are no true one; empty if there is none."""
    rest = sorted(estimates.keys() - {robot.robot_id for robot in errors})
    if not rest:
        return []
    each = (f"{name} ({counted(len(estimates[name].stamps_ns), 'position')})" for name in rest)
    return [
        f"Published, but paired with no true robot and in none of the errors: {', '.join(each)}."
    ]


def _write(
    folder: Path,
    args: argparse.Namespace,
    found: _Found,
    errors: list[RobotErrors],
    identity: Identities | None,
    figures: dict[str, Any],
) -> None:
    source = args.hover or args.verify or args.truth
    facts = [("result", str(args.result)), ("truth", ", ".join(map(str, source)))]
    if found.truth.latency_s:
        facts.append(("latency of the images", f"{found.truth.latency_s:g} s"))
    report = Report(
        f"Evaluation of {args.result.name}", found.notes, found.estimates, found.truth.robots,
        found.truth.drone, read_rejections(args.result / "rejected.csv"),
        {"published positions": errors}, (), facts, identity,
        read_platform(args.result / "platform.csv"),
        drones=read_drones(args.result / "drones.csv"),
    )  # fmt: skip
    pictures = draw(report)
    for picture in pictures:
        (folder / picture.name).write_bytes(picture.content)
    write_report(folder / "report.html", report, pictures)
    (folder / "summary.json").write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    _write_errors(folder / "errors.csv", errors)


def _write_errors(path: Path, errors: Sequence[RobotErrors]) -> None:
    stamps = np.unique(np.concatenate([robot.stamps_ns for robot in errors]))
    rows: list[tuple[int, str, list[str]]] = []
    for robot in errors:
        names = spreadsheet_cell(robot.truth_id), spreadsheet_cell(robot.robot_id)
        east, north = robot.east_north.T
        columns = robot.distance, robot.haversine, north, east, robot.nees, robot.sigma
        values = np.column_stack([*columns, robot.range_m])
        for frame, stamp, row in zip(
            np.searchsorted(stamps, robot.stamps_ns), robot.stamps_ns, values, strict=True
        ):
            text = [str(stamp), *names, *(f"{value:.4f}" for value in row)]
            rows.append((int(frame), robot.truth_id, text))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(ERROR_COLUMNS)
        writer.writerows([frame, *text] for frame, _, text in sorted(rows))


def _as_dict(
    errors: list[RobotErrors], identity: Identities | None, found: _Found
) -> dict[str, Any]:
    return {
        "all": summarise(errors).figures(),
        "robots": {
            robot.truth_id: {
                "robot_id": robot.robot_id,
                "availability": robot.coverage,
                **summarise([robot]).figures(),
            }
            for robot in errors
        },
        "identity": None if identity is None else asdict(identity),
        "latency_s": found.truth.latency_s,
        "hovers": [asdict(hover) for hover in found.hovers],
        "notes": found.notes,
    }


def _as_text(errors: list[RobotErrors], identity: Identities | None, found: _Found) -> str:
    head = (
        f"{'true robot':<13} {'published as':<14} {'positions':>9} {'availability':>12} "
        f"{'CEP':>7} {'CE90':>6} {'p95':>6} {'RMSE (m)':>9} {'NEES':>6}"
    )
    lines = [*found.notes, head]
    for robot in [*errors, None]:
        s = summarise(errors if robot is None else [robot])
        name, other, share = "all", "", ""
        if robot is not None:
            name, other = robot.truth_id, robot.robot_id or "not found"
            share = f"{robot.coverage:.0%}"
        lines.append(
            f"{name:<13} {other:<14} {s.count:>9} {share:>12} {metres(s.median):>7} "
            f"{metres(s.ce90):>6} {metres(s.p95):>6} {metres(s.rmse):>9} {metres(s.nees):>6}"
        )
    if identity is not None:
        scores = f"IDF1 and switches need motmetrics: {install_hint('identity')}"
        if identity.idf1 is not None:
            switches = counted(identity.switches or 0, "switch")
            fragments = counted(identity.fragmentations or 0, "fragment")
            scores = f"IDF1 {identity.idf1:.3f}, {switches}, {fragments}"
        lines.append(f"identity: HOTA {identity.hota:.3f}, {scores}")
    return "\n".join(lines)
