# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Arguments of `aerial-gnss replay` for several drones."""

from __future__ import annotations

import argparse
import re
from collections import Counter
from pathlib import Path

from aerial_gnss_ros.core.values.errors import ConfigError

_NAME = re.compile(r"[a-z][a-z0-9_]*")


def drone_file(text: str) -> tuple[str, Path]:
    """Parse NAME=PATH, such as a=flight_bag."""
    name, path = _named(text, "PATH")
    return name, Path(path)


def drone_namespace(text: str) -> tuple[str, str]:
    """Parse NAME=NAMESPACE, such as a=drone1."""
    return _named(text, "NAMESPACE")


def _named(text: str, what: str) -> tuple[str, str]:
    name, equals, given = text.partition("=")
    if not (equals and given and _NAME.fullmatch(name)):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not NAME={what} with a name of small letters, digits and underscores"
        )
    return name, given


def add_arguments(group: argparse._ArgumentGroup) -> None:
    """Add the arguments for several drones."""
    group.add_argument(
        "--drone", type=drone_file, action="append", default=[], metavar="NAME=BAG",
        help="recording of one of several drones, in place of BAG; repeated for each drone. Stamps "
        "of all must be of one clock",
    )  # fmt: skip
    group.add_argument(
        "--drone-params", type=drone_file, action="append", default=[], metavar="NAME=FILE",
        help="with --drone: parameters of this drone alone, after those of --params",
    )  # fmt: skip
    group.add_argument(
        "--drone-namespace", type=drone_namespace, action="append", default=[],
        metavar="NAME=NAMESPACE",
        help="with --drone: namespace of this drone's relative topics, in place of --namespace",
    )  # fmt: skip
    group.add_argument(
        "--gnss-share", type=float, metavar="P",
        help="with --drone: part of the variance of the receivers' offsets that is common to all "
        "drones, as far as is known beforehand, 0 to 1 (default 0.5)",
    )  # fmt: skip


def check(args: argparse.Namespace) -> None:
    """Refuse arguments that do not go together.

    Raises:
        ConfigError: says which.
    """
    if not args.drone:
        for name in ("drone_params", "drone_namespace", "gnss_share"):
            if getattr(args, name):
                raise ConfigError(f"--{name.replace('_', '-')} applies only with --drone.")
        if not args.bags:
            raise ConfigError("give a BAG, or --drone NAME=BAG for each of several drones.")
        return
    if args.bags or args.each:
        other = "BAG" if args.bags else "--each"
        raise ConfigError(f"give {other} or --drone, not both.")
    twice = [name for name, count in Counter(name for name, _ in args.drone).items() if count > 1]
    if twice:
        raise ConfigError(f"two drones are called {twice[0]}; each needs a name of its own.")
    for option in ("drone_params", "drone_namespace"):
        unknown = {name for name, _ in getattr(args, option)} - {name for name, _ in args.drone}
        if unknown:
            given = f"--{option.replace('_', '-')}"
            raise ConfigError(f"{given} names {min(unknown)}, which is none of the drones.")
    _refuse_one_recording(args)
    share = args.gnss_share
    if share is not None and not 0.0 <= share <= 1.0:
        raise ConfigError(f"--gnss-share must lie within 0 to 1, not {share:g}.")


def namespace(args: argparse.Namespace, drone: str) -> str:
    """Return the namespace in which a drone's relative topics were recorded."""
    own: str = dict(args.drone_namespace).get(drone, args.namespace)
    return own.strip("/")


def _refuse_one_recording(args: argparse.Namespace) -> None:
    """Refuse a recording of one drone as that of two: its errors would count as independent."""
    of = dict[tuple[Path, tuple[Path, ...], str], str]()
    for name, path in args.drone:
        own = tuple(file.resolve() for drone, file in args.drone_params if drone == name)
        other = of.setdefault((path.resolve(), own, namespace(args, name)), name)
        if other != name:
            raise ConfigError(
                f"{other} and {name} have the same recording, {path}; give one of each drone, or "
                "--drone-namespace or --drone-params with each one's topics if it contains both."
            )
