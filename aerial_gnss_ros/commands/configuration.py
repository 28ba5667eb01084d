# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters from a vehicle profile, parameter files and the command line, in this order."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aerial_gnss_ros.adapters.parameter_files import read
from aerial_gnss_ros.adapters.vehicles import vehicle_file, vehicle_names
from aerial_gnss_ros.commands.notices import note
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.detection.config import DetectorConfig, detector_config
from aerial_gnss_ros.nodes.schemas import DETECTOR, ESTIMATOR, SCHEMAS


@dataclass(frozen=True)
class Configuration:
    """Parameters of detector and estimator."""

    detector: DetectorConfig
    estimator: EstimatorConfig


def add_arguments(parser: argparse._ActionsContainer) -> None:
    """Add the arguments that select parameters."""
    parser.add_argument(
        "--params",
        type=Path,
        action="append",
        default=[],
        metavar="YAML",
        help="parameter file as for the nodes; may be repeated, later ones take precedence",
    )
    parser.add_argument(
        "--vehicle",
        metavar="NAME|PATH",
        help=f"vehicle profile: {', '.join(vehicle_names())}, or a file",
    )
    parser.add_argument(
        "--namespace", default="", help="namespace of relative topics, such as drone1"
    )
    parser.add_argument(
        "--method",
        choices=("filter", "single", "paper"),
        help="filter: tracked over time; single: each image alone; paper: the published equations",
    )
    parser.add_argument(
        "--model", metavar="FILE", help="detection model (default: the shipped one)"
    )


def values_of(files: Sequence[Path], namespace: str = "") -> dict[str, dict[str, Any]]:
    """Return the parameters of files by node, and say which entries of theirs are left out.

    Args:
        files: later ones take precedence.
        namespace: of the nodes.

    Raises:
        ConfigError: a file is missing, or a parameter is unknown, of a wrong type or out of range.
    """
    return {name: dict(of) for name, of in read(files, SCHEMAS, f"/{namespace}", note).items()}


def configuration(args: argparse.Namespace) -> Configuration:
    """Return the configuration that the arguments select.

    Raises:
        ConfigError: a file is missing, or a parameter is unknown, of a wrong type or out of range.
    """
    files = [*([vehicle_file(args.vehicle)] if args.vehicle else []), *args.params]
    namespace = args.namespace.strip("/")
    values = values_of(files, namespace)
    detector: dict[str, Any] = {"model": args.model} if args.model else {}
    estimator: dict[str, Any] = {"method": args.method} if args.method else {}
    try:
        return Configuration(
            detector_config(values[DETECTOR] | detector),
            estimator_config(values[ESTIMATOR] | estimator),
        )
    except ConfigError as error:
        raise _with_files(error, files, namespace) from error


def _with_files(error: ConfigError, files: Sequence[Path], namespace: str) -> ConfigError:
    """Return an error about values of several files, named by those that give its group."""
    group = re.split(r"[^a-z_]", str(error), maxsplit=1)[0]
    givers = [file for file in files if group in _groups(file, namespace)]
    return ConfigError(f"{', '.join(map(str, givers))}: {error}") if givers else error


def _groups(file: Path, namespace: str) -> set[str]:
    values = read([file], SCHEMAS, f"/{namespace}", lambda _: None)
    return {name.split(".", 1)[0] for of in values.values() for name in of}
