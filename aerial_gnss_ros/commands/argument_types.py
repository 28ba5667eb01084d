# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Types of command-line arguments that explain why a value is refused."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable

from aerial_gnss_ros.bags.writer import VERSIONS
from aerial_gnss_ros.core.config.noise import SETS


def add_rosbag_version(parser: argparse.ArgumentParser) -> None:
    """Add `--rosbag-version`."""
    parser.add_argument(
        "--rosbag-version", type=int, choices=VERSIONS,
        help="of the bag's files: 8 for ROS 2 Humble and Iron, 9 for Jazzy and later (default: of "
        "the ROS that is found, else 9)",
    )  # fmt: skip


def numbers(*counts: int) -> Callable[[str], tuple[float, ...]]:
    """Return a parser of numbers separated by commas, as many as one of `counts`."""

    def parse(text: str) -> tuple[float, ...]:
        try:
            values = tuple(float(part) for part in text.split(","))
        except ValueError:
            values = ()
        if len(values) not in counts or not all(map(math.isfinite, values)):
            wanted = " or ".join(map(str, counts))
            raise argparse.ArgumentTypeError(
                f"{text!r} is not {wanted} numbers separated by commas"
            )
        return values

    return parse


def size(text: str) -> tuple[int, int]:
    """Parse an image size such as 1280x720."""
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise argparse.ArgumentTypeError(f"{text!r} is not a size such as 1280x720")
    sides = int(width), int(height)
    if not all(64 <= side <= 8192 for side in sides):
        raise argparse.ArgumentTypeError(f"{text!r}: both sides must lie within 64 to 8192 px")
    return sides


def sigma(text: str) -> tuple[str, float]:
    """Parse a standard deviation of `core.config.noise`, such as gnss_offset_m=0.02."""
    name, _, value = text.partition("=")
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if name not in SETS["consumer"] or not (math.isfinite(number) and number >= 0.0):
        raise argparse.ArgumentTypeError(
            f"{text!r} is not NAME=VALUE with a name of {', '.join(SETS['consumer'])} and a value "
            "of 0 or more"
        )
    return name, number
