# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss evaluate`: errors of a replay's positions against the truth of a bag."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from aerial_gnss_ros.bags.partial import partial, refuse_existing
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.tables import read_positions, read_rejections
from aerial_gnss_ros.core.errors import InputError
from aerial_gnss_ros.evaluation.errors import RobotErrors, compare, summarise
from aerial_gnss_ros.evaluation.report import Report, metres, write_report
from aerial_gnss_ros.evaluation.truth import read_truth


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("result", type=Path, metavar="RESULT", help="folder that replay wrote")
    parser.add_argument(
        "--truth", type=Path, nargs="+", required=True, metavar="BAG",
        help="bag with truth/robots/<id>/fix",
    )  # fmt: skip
    parser.add_argument("-o", "--output", type=Path, metavar="HTML", help="write a report too")
    parser.add_argument("--json", action="store_true", help="the figures for machines")


def run(args: argparse.Namespace) -> int:
    """Compare and print."""
    if args.output is not None:
        refuse_existing(args.output)
    estimates = read_positions(args.result / "positions.csv")
    with open_bag(args.truth) as bag:
        truth = read_truth(bag)
        if not truth.robots:
            raise InputError(
                f"{', '.join(map(str, args.truth))} has no truth: no topic is named "
                f"truth/robots/<id>/fix; it has {', '.join(bag.topics) or 'no topics'}."
            )
    errors = compare(estimates, truth.robots)
    if args.output is not None:
        rejections = read_rejections(args.result / "rejected.csv")
        report = Report(
            f"Evaluation of {args.result.name}", [], estimates, truth.robots, truth.drone,
            rejections, {"published positions": errors},
        )  # fmt: skip
        with partial(args.output) as path:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_report(path, report)
    if args.json:
        print(json.dumps(_as_dict(errors), indent=2))
    else:
        print(_as_text(errors))
    return 0


def _as_dict(errors: list[RobotErrors]) -> dict[str, object]:
    return {
        "all": asdict(summarise(errors)),
        "robots": {
            robot.truth_id: {
                "robot_id": robot.robot_id,
                "availability": robot.coverage,
                **asdict(summarise([robot])),
            }
            for robot in errors
        },
    }


def _as_text(errors: list[RobotErrors]) -> str:
    lines = ["true robot    published as   positions  availability   median      p95     RMSE (m)"]
    for robot in errors:
        s = summarise([robot])
        lines.append(
            f"{robot.truth_id:<13} {robot.robot_id or 'not found':<14} {s.count:>9} "
            f"{robot.coverage:>12.0%} {metres(s.median):>8} {metres(s.p95):>8} {metres(s.rmse):>8}"
        )
    s = summarise(errors)
    lines.append(
        f"{'all':<13} {'':<14} {s.count:>9} {'':>12} {metres(s.median):>8} {metres(s.p95):>8} "
        f"{metres(s.rmse):>8}"
    )
    return "\n".join(lines)
