# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss run`: detector and estimator, each a process that is restarted; or the fleet."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from aerial_gnss_ros.adapters.vehicles import vehicle_file, vehicle_names
from aerial_gnss_ros.commands.notices import note
from aerial_gnss_ros.core.values.errors import AerialGnssError, ConfigError
from aerial_gnss_ros.nodes import require_ros
from aerial_gnss_ros.nodes.leaving import leave_on_signals
from aerial_gnss_ros.nodes.ros_arguments import refuse_one_name_for_both
from aerial_gnss_ros.nodes.schemas import FLEET

NODES = ("detector", "estimator")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `run`."""
    parser.epilog = (
        "A parameter's value is taken from the first that has it: --ros-args, the last --params, "
        "the vehicle profile, the defaults (config/detector.yaml, config/estimator.yaml)."
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
    parser.add_argument("--namespace", metavar="NS", help="namespace of both nodes, such as drone1")
    ways = parser.add_mutually_exclusive_group()
    ways.add_argument(
        "--one-process", action="store_true",
        help="both nodes in one process, which is not restarted; needs less memory",
    )  # fmt: skip
    ways.add_argument(
        "--node",
        choices=(*NODES, FLEET),
        help="only this node, not restarted (for launch files); fleet joins several drones",
    )
    parser.add_argument(
        "--session", type=Path, metavar="FILE",
        help="with --node: file in which the estimator keeps labels for a restart",
    )  # fmt: skip
    parser.add_argument(
        "--enclave",
        metavar="PATH",
        help="SROS2 enclave, such as /aerial_gnss; each node's is below it",
    )
    parser.add_argument("--refusal", type=Path, help=argparse.SUPPRESS)
    parser.add_argument(
        "--ros-args",
        nargs=argparse.REMAINDER,
        default=[],
        metavar="ARG",
        help="arguments for ROS; must come last: -r FROM:=TO, -p NAME:=VALUE, --log-level LEVEL",
    )


def run(args: argparse.Namespace) -> int:
    """Start the nodes and return when a signal ends them."""
    leave_on_signals()
    require_ros()
    if args.node == FLEET and (args.vehicle or args.session):
        given = "--vehicle" if args.vehicle else "--session"
        raise ConfigError(f"{given} is for the nodes of a drone: the fleet has none.")
    if not args.node:
        refuse_one_name_for_both(args.ros_args)
    vehicle = [vehicle_file(args.vehicle)] if args.vehicle else []
    if args.node or args.one_process:
        return _here(args, [*vehicle, *args.params])
    return _supervised(args, [*vehicle, *args.params])


def _here(args: argparse.Namespace, files: list[Path]) -> int:
    """Run one node, or both, in this process."""
    from aerial_gnss_ros.nodes import process
    from aerial_gnss_ros.nodes.both import both, only
    from aerial_gnss_ros.nodes.supervised import Given

    given = Given(files, args.namespace, args.session)
    makers: list[Callable[[], Any]] = [only(args.node, given)] if args.node else both(given)
    try:
        return process.spin(makers, ["aerial-gnss", "--ros-args", *args.ros_args, *_enclave(args)])
    except AerialGnssError as error:
        if args.refusal is None:
            raise
        args.refusal.write_text(str(error), encoding="utf-8")
        return process.WRONG_INPUT


def _supervised(args: argparse.Namespace, files: list[Path]) -> int:
    """Run each node in its own process; raise the error of the first that refuses its input."""
    from aerial_gnss_ros.nodes.supervisor import node_environment, supervise

    node_environment()
    with tempfile.TemporaryDirectory(prefix="aerial_gnss_") as folder:
        refusal = Path(folder) / "refusal"
        given = ["--session", f"{folder}/names.json", "--refusal", str(refusal)]
        if files:
            given += ["--params", *map(str, files)]
        if args.namespace is not None:
            given += ["--namespace", args.namespace]
        if args.enclave:
            given += ["--enclave", args.enclave]
        program = [sys.executable, "-m", "aerial_gnss_ros.cli", "run"]
        ros = ["--ros-args", *args.ros_args]
        commands = {name: [*program, "--node", name, *given, *ros] for name in NODES}
        status = supervise(commands, note)
        if refusal.is_file():
            raise AerialGnssError(refusal.read_text(encoding="utf-8"))
    return status


def _enclave(args: argparse.Namespace) -> list[str]:
    """Return the ROS arguments that set the enclave of this process."""
    if not args.enclave:
        return []
    return ["--enclave", "/".join(filter(None, (args.enclave.rstrip("/"), args.node)))]
