# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss profiles`: lists and prints the vehicle profiles of the package."""

from __future__ import annotations

import argparse
import json

from aerial_gnss_ros.adapters.vehicles import vehicle_names, vehicle_summary, vehicle_text
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.resources import config_path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Use one with --vehicle NAME (run, replay) or vehicle:=NAME (launch). For another drone: "
        "aerial-gnss profiles NAME > mine.yaml, edit it, and give its path instead; --keys "
        "explains all keys."
    )
    parser.add_argument("name", nargs="?", metavar="NAME", help="print this profile")
    parser.add_argument(
        "--keys", action="store_true",
        help="print every key of both nodes with unit, meaning, default and consequence",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print the list as JSON")


def run(args: argparse.Namespace) -> int:
    """List the profiles, or print one, or the keys of all."""
    if args.keys:
        if args.name or args.json:
            raise InputError("--keys takes no profile: every profile has the same keys.")
        for node in ("detector", "estimator"):
            print(config_path(f"{node}.yaml").read_text(encoding="utf-8"), end="")
        return 0
    if args.name and args.json:
        raise InputError("--json is for the list; a profile is printed as YAML.")
    if args.name:
        print(vehicle_text(args.name), end="")
        return 0
    found = {name: vehicle_summary(name) for name in vehicle_names()}
    if args.json:
        print(json.dumps(found, indent=2))
        return 0
    width = max(map(len, found))
    for name, summary in found.items():
        print(f"{name:<{width}}  {summary}")
    return 0
