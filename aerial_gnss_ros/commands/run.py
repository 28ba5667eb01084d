# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss run`: detector and estimator in one process, until a signal."""

from __future__ import annotations

import argparse
from pathlib import Path

from aerial_gnss_ros.adapters.vehicles import vehicle_file, vehicle_names
from aerial_gnss_ros.nodes import require_ros
from aerial_gnss_ros.nodes.leaving import leave_on_signals

HELP = "start detector and estimator nodes in one process"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `run`."""
    parser.epilog = (
        "A parameter's value comes from, in this order, --ros-args, the last --params that has it, "
        "the vehicle profile, the default (config/detector.yaml, config/estimator.yaml)."
    )
    parser.add_argument(
        "--vehicle", metavar="NAME|PATH", help=f"vehicle profile: {', '.join(vehicle_names())}"
    )
    parser.add_argument(
        "--params",
        metavar="YAML",
        type=Path,
        nargs="+",
        action="extend",
        default=[],
        help="parameter files",
    )
    parser.add_argument("--namespace", metavar="NS", help="of both nodes, such as drone1")
    parser.add_argument(
        "--ros-args",
        nargs=argparse.REMAINDER,
        default=[],
        metavar="ARG",
        help="everything after it goes to ROS: -r FROM:=TO, -p NAME:=VALUE, --log-level LEVEL",
    )


def run(args: argparse.Namespace) -> int:
    """Start both nodes and return when a signal ends them."""
    leave_on_signals()
    require_ros()
    from aerial_gnss_ros.nodes import process
    from aerial_gnss_ros.nodes.both import both
    from aerial_gnss_ros.nodes.supervised import Given

    vehicle = [vehicle_file(args.vehicle)] if args.vehicle else []
    given = Given((*vehicle, *args.params), args.namespace)
    return process.spin(both(given), ["aerial-gnss", "--ros-args", *args.ros_args])
