# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss where ROBOT`: asks the live estimator once where a robot is."""

from __future__ import annotations

import argparse
import json
import math
import time
from dataclasses import dataclass
from typing import Any

from aerial_gnss_ros.adapters.map_frame import UNKNOWN_LENGTH_M2
from aerial_gnss_ros.adapters.sightings import Sighting, sighting
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.nodes import require_ros
from aerial_gnss_ros.text.sentences import utc

TWO_SIGMA_95 = 2.448
"""Ratio of the 95 % circle's radius to one sigma per axis, with two degrees of freedom."""
LOST_M = 0.9 * math.sqrt(UNKNOWN_LENGTH_M2)
ANSWERED, NOT_MEASURED = 0, 1
_LONGEST_S = 86_400.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Status 0: the position is measured; 1: it is predicted, or the robot is lost. "
        "Ten lines of Python do the same: docs/howto/consuming.md."
    )
    parser.add_argument("robot", metavar="ROBOT", help="its label, such as aqua_1")
    parser.add_argument(
        "--namespace", default="", help="namespace of the estimator, such as drone1"
    )
    parser.add_argument(
        "--measured", action="store_true",
        help="wait for a measured position received after the request",
    )  # fmt: skip
    parser.add_argument(
        "--seconds", type=float, default=10.0, metavar="S", help="longest wait, s (%(default)g)"
    )
    parser.add_argument("--json", action="store_true", help="print the answer as JSON")


def run(args: argparse.Namespace) -> int:
    """Ask, and print the answer."""
    if not 0.0 < args.seconds <= _LONGEST_S:
        raise InputError(
            f"--seconds must be above 0 and at most {_LONGEST_S:.0f}, not {args.seconds:g}."
        )
    require_ros()
    from aerial_gnss_ros.nodes.robots import ask

    latched: list[int] = []

    def wanted(message: Any) -> bool:
        """Accept the first answer, or with --measured the first new measurement."""
        if not args.measured:
            return True
        seen = sighting(args.robot, message)
        latched.append(seen.stamp_ns)
        return seen.measured and seen.stamp_ns > latched[0]

    heard, spent_s, others = ask(args.robot, args.namespace, args.seconds, wanted)
    if heard is None:
        raise InputError(_nothing(args, others, bool(latched)))
    answer = Answer(sighting(args.robot, heard, args.namespace), spent_s)
    print(json.dumps(answer.fields()) if args.json else answer.words())
    return ANSWERED if answer.state == "measured" else NOT_MEASURED


@dataclass(frozen=True)
class Answer:
    """The estimator's answer about a robot.

    Attributes:
        seen: the position.
        spent_s: time from request to answer, s.
    """

    seen: Sighting
    spent_s: float

    @property
    def state(self) -> str:
        """measured, predicted or lost."""
        if self.seen.measured:
            return "measured"
        return "lost" if self.seen.sigma >= LOST_M else "predicted"

    @property
    def age_s(self) -> float:
        """Age of the position by this computer's clock, s."""
        return time.time() - self.seen.stamp_ns * 1e-9

    def fields(self) -> dict[str, Any]:
        """Return the answer as JSON fields."""
        seen = self.seen
        return {
            "robot": seen.robot_id,
            "state": self.state,
            "latitude_deg": math.degrees(seen.latitude),
            "longitude_deg": math.degrees(seen.longitude),
            "altitude_m": None if math.isnan(seen.altitude) else seen.altitude,
            "sigma_m": seen.sigma,
            "stamp_ns": seen.stamp_ns,
            "age_s": self.age_s,
            "asked_to_answered_s": self.spent_s,
        }

    def words(self) -> str:
        """Return the answer in words."""
        seen = self.seen
        name = f"{seen.namespace}/{seen.robot_id}" if seen.namespace else seen.robot_id
        when = f"{utc(seen.stamp_ns)}, {self.age_s:.1f} s ago"
        place = f"{math.degrees(seen.latitude):.7f}, {math.degrees(seen.longitude):.7f}"
        if self.state == "lost":
            return f"{name} has been lost since {when}; its last predicted position is {place}."
        return (
            f"{name} is at {place}, 95 % within {TWO_SIGMA_95 * seen.sigma:.1f} m; "
            f"{self.state}, {when}."
        )


def _nothing(args: argparse.Namespace, others: list[str], heard: bool) -> str:
    """Return why there is no answer, and what to do."""
    if heard:
        return (
            f"{args.robot} was not measured within {args.seconds:g} s; without --measured the "
            "last known position is printed."
        )
    known = f"only {', '.join(others)}" if others else "no robot"
    known += " are" if len(others) > 1 else " is"
    return (
        f"no position of {args.robot} within {args.seconds:g} s; {known} published here. Check "
        "the estimator, its --namespace, ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE."
    )
