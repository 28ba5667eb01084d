# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Arguments of `aerial-gnss simulate` that describe the flight."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from aerial_gnss_ros.commands.argument_types import numbers, sigma, size
from aerial_gnss_ros.core.config.noise import SETS
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.flight import KINDS
from aerial_gnss_ros.simulation.formation import FORMATIONS
from aerial_gnss_ros.simulation.robot_models import AQUA, MODELS, robot_model

DURATION_S = 60.0
RENDERED_S = 20.0
"""Of a flight with images, which take their time: 20 s are ready in half a minute on two cores."""

WATER_M = 30.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    _flight_arguments(parser.add_argument_group("flight"))
    _formation_arguments(parser.add_argument_group("several drones"))
    _robot_arguments(parser.add_argument_group("robots"))
    _sensor_arguments(parser.add_argument_group("sensors"))
    _image_arguments(parser.add_argument_group("images"))


def defaults() -> dict[str, Any]:
    """Return the arguments' defaults."""
    parser = argparse.ArgumentParser(add_help=False)
    add_arguments(parser)
    return vars(parser.parse_args([]))


def _flight_arguments(group: Any) -> None:
    group.add_argument(
        "--flight", choices=KINDS, help="flight path: hover (default), orbit or transit"
    )
    group.add_argument(
        "--telemetry", type=Path, metavar="CSV", help="fly a recorded DJI flight record instead"
    )
    group.add_argument(
        "--start", type=float, metavar="S", help="with --telemetry: start in the log, s (default 0)"
    )
    group.add_argument(
        "--duration", type=float, metavar="S",
        help=f"length, s (default {RENDERED_S:g} with images, {DURATION_S:g} without)",
    )  # fmt: skip
    group.add_argument(
        "--height", type=float, metavar="M", help="height above the water, m (default 15)"
    )
    group.add_argument(
        "--tilt", type=float, metavar="DEG",
        help=
                "angle of the camera below the horizon, deg (default 55; 90 looks straight down, "
                "at the first robot)",
    )  # fmt: skip
    group.add_argument(
        "--fixed-gimbal",
        action="store_true",
        help="keep the tilt constant instead of following the robots",
    )
    group.add_argument(
        "--stand-off", type=float, metavar="M",
        help=
                "horizontal distance to the robots, or radius of the orbit, m (default: from the "
                "tilt)",
    )  # fmt: skip
    group.add_argument(
        "--speed", type=float, metavar="MPS", help="speed of the drone, m/s (default 2)"
    )
    group.add_argument(
        "--camera-offset", type=numbers(3), metavar="X,Y,Z",
        help="camera position relative to the GNSS antenna: forward, left, up, m (default 0,0,0)",
    )  # fmt: skip


def _formation_arguments(group: Any) -> None:
    group.add_argument(
        "--drones", type=int, metavar="N",
        help="number of drones over the same robots: -o becomes a folder with a bag for each, "
        "called a, b, ...",
    )  # fmt: skip
    group.add_argument(
        "--formation", choices=tuple(FORMATIONS),
        help="with --drones: opposite (default; evenly around the robots), beside (20 deg apart), "
        "above (the others hover above) or far (the others see the robots at a grazing angle)",
    )  # fmt: skip
    group.add_argument(
        "--gnss-share", type=float, metavar="P",
        help="with --drones: part of the variance of the receivers' offsets that all have in "
        "common, 0 to 1 (default 0.5)",
    )  # fmt: skip
    group.add_argument(
        "--drone-noise", choices=(*SETS, "none"), action="append", metavar="SET",
        help="with --drones: set of sensor errors of drone a, b, ... in turn; repeated for each "
        "drone (default: --noise for all)",
    )  # fmt: skip


def _robot_arguments(group: Any) -> None:
    group.add_argument("--robots", type=int, metavar="N", help="number of robots (default 3)")
    group.add_argument(
        "--robot-at", type=numbers(2), action="append", metavar="LAT,LON",
        help=
                "a robot's position, degrees; may be repeated. It stays there unless "
                "--robot-speed is given. (South: write --robot-at=-13.1,59.6)",
    )  # fmt: skip
    group.add_argument(
        "--robot-speed", type=numbers(1, 2), metavar="MPS[,MPS]",
        help="speeds of the robots, slowest and fastest, m/s (default 0.15,0.6; 0 stays)",
    )  # fmt: skip
    group.add_argument(
        "--reference", type=float, metavar="M",
        help="add one object that stays and whose position is known to M (one sigma): of class "
        "beacon without images, else one of the robots",
    )  # fmt: skip
    group.add_argument(
        "--robot-model", type=robot_models, default=(AQUA,), metavar="MODEL[,MODEL]",
        help=f"shape of the robots and name of their class: {', '.join(MODELS)}, or a mesh "
        f"file (.obj, .gltf, .glb; metres); of several, the robots of a flight take turns (default "
        f"{AQUA})",
    )  # fmt: skip
    group.add_argument(
        "--dives", action="store_true", help="robots dive out of sight from time to time"
    )


def robot_models(text: str) -> tuple[str, ...]:
    """Return the models that an argument names.

    Raises:
        argparse.ArgumentTypeError: there is no such model.
    """
    try:
        names = tuple(name.strip() for name in text.split(","))
        for name in names:
            robot_model(name)
    except ConfigError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return names


def _sensor_arguments(group: Any) -> None:
    group.add_argument(
        "--noise", choices=(*SETS, "none"), default="consumer",
        help="set of sensor errors (default consumer)",
    )  # fmt: skip
    group.add_argument(
        "--sigma", action="append", default=[], metavar="NAME=VALUE", type=sigma,
        help=f"replace one error of the set: {', '.join(SETS['consumer'])}",
    )  # fmt: skip
    group.add_argument("--fix-covariance", action="store_true", help="fixes carry their covariance")
    group.add_argument(
        "--latency", type=float, default=0.0, metavar="S",
        help="an image stamped t shows the scene at t - S (default 0)",
    )  # fmt: skip
    group.add_argument("--rate", type=float, default=10.0, metavar="HZ", help="images (default 10)")


def _image_arguments(group: Any) -> None:
    group.add_argument(
        "--size", type=size, default=(1280, 720), metavar="WxH", help="px (default 1280x720)"
    )
    group.add_argument(
        "--field-of-view", type=float, default=73.7, metavar="DEG",
        help="horizontal field of view, deg (default 73.7)",
    )  # fmt: skip
    group.add_argument(
        "--scene", choices=("demo", "random"), default="demo",
        help="demo: a bright afternoon; random: random light and water from the seed",
    )  # fmt: skip
    group.add_argument(
        "--water", type=Path, metavar="FILE",
        help="photograph of water, taken straight down, that is laid on the water and repeated, "
        "mirrored; --scene lights what floats on it",
    )  # fmt: skip
    group.add_argument(
        "--water-width", type=float, metavar="M",
        help=f"width of the photograph on the water, m (default {WATER_M:g})",
    )  # fmt: skip
    group.add_argument("--raw", action="store_true", help="raw images in a compressed bag, no JPEG")
    group.add_argument(
        "--no-images", action="store_true", help="no images but simulated detections: fast"
    )
    group.add_argument(
        "--missed", type=float, default=0.0, metavar="P",
        help="with --no-images: probability that a robot is not detected",
    )  # fmt: skip
    group.add_argument(
        "--false-boxes", type=float, default=0.0, metavar="N",
        help="with --no-images: mean number of false boxes per image",
    )  # fmt: skip
