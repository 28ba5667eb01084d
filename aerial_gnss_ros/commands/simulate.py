# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss simulate`: a bag of a flight that never was, or of robots under one that was.

With `--dataset`, labelled pictures instead (simulate_dataset.py).
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters.dji_log import DjiLog, read_dji_log, summarise_refusals
from aerial_gnss_ros.bags.partial import refuse_existing
from aerial_gnss_ros.commands import simulate_dataset
from aerial_gnss_ros.commands.argument_types import numbers, sigma, size
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.errors import ConfigError, InputError
from aerial_gnss_ros.core.geodesy import enu_from_geodetic
from aerial_gnss_ros.core.noise import SETS
from aerial_gnss_ros.core.words import counted
from aerial_gnss_ros.simulation.bag import write_bag
from aerial_gnss_ros.simulation.boxes import DetectorPlan
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.flight import KINDS, Flight, FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.recorded import RecordedFlight, water_seconds
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.scenario import scenario, words
from aerial_gnss_ros.simulation.scene import Scene, demo_scene, random_scene
from aerial_gnss_ros.simulation.sensors import SensorPlan, sensor_plan

HELP = "make a bag of a simulated flight with rendered images and truth, or pictures to train on"
DURATION_S = 60.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("-o", "--output", type=Path, help="the bag to make (folder)")
    _flight_arguments(parser.add_argument_group("flight"))
    _robot_arguments(parser.add_argument_group("robots"))
    _sensor_arguments(parser.add_argument_group("sensors"))
    _image_arguments(parser.add_argument_group("images"))
    simulate_dataset.add_arguments(parser.add_argument_group("pictures to train on"))
    parser.add_argument("--seed", type=int, default=1, help="same seed, same bytes (default 1)")
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")


def _flight_arguments(group: Any) -> None:
    group.add_argument("--flight", choices=KINDS, help="hover (default), orbit or transit")
    group.add_argument(
        "--telemetry", type=Path, metavar="CSV", help="fly a recorded DJI flight record instead"
    )
    group.add_argument(
        "--start", type=float, metavar="S", help="with --telemetry: where to begin, s (default 0)"
    )
    group.add_argument(
        "--duration", type=float, default=DURATION_S, metavar="S", help="length, s (default 60)"
    )
    group.add_argument("--height", type=float, metavar="M", help="above the water (default 15 m)")
    group.add_argument(
        "--tilt", type=float, metavar="DEG",
        help="camera below the horizon (default 55; 90 looks straight down, at the first robot)",
    )  # fmt: skip
    group.add_argument(
        "--fixed-gimbal", action="store_true", help="hold the tilt instead of following the robots"
    )
    group.add_argument(
        "--stand-off", type=float, metavar="M",
        help="horizontal distance to the robots, radius of the orbit (default: from the tilt)",
    )  # fmt: skip
    group.add_argument("--speed", type=float, metavar="MPS", help="of the drone (default 2 m/s)")
    group.add_argument(
        "--camera-offset", type=numbers(3), metavar="X,Y,Z",
        help="camera relative to the GNSS antenna: forward, left, up, m (default 0,0,0)",
    )  # fmt: skip


def _robot_arguments(group: Any) -> None:
    group.add_argument("--robots", type=int, metavar="N", help="how many (default 3)")
    group.add_argument(
        "--robot-at", type=numbers(2), action="append", metavar="LAT,LON",
        help="a robot's place, degrees; repeat for more. It stays unless --robot-speed is given. "
        "(South: write --robot-at=-13.1,59.6)",
    )  # fmt: skip
    group.add_argument(
        "--robot-speed", type=numbers(1, 2), metavar="MPS[,MPS]",
        help="of the robots, from slowest to fastest (default 0.15,0.6; 0 stays)",
    )  # fmt: skip
    group.add_argument("--dives", action="store_true", help="robots dive out of sight now and then")


def _sensor_arguments(group: Any) -> None:
    group.add_argument(
        "--noise", choices=(*SETS, "none"), default="consumer",
        help="set of sensor errors (default consumer)",
    )  # fmt: skip
    group.add_argument(
        "--sigma", action="append", default=[], metavar="NAME=VALUE", type=sigma,
        help=f"replace one error of the set: {', '.join(SETS['consumer'])}",
    )  # fmt: skip
    group.add_argument("--fix-covariance", action="store_true", help="fixes state their covariance")
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
        help="across the image (default 73.7)",
    )  # fmt: skip
    group.add_argument(
        "--scene", choices=("demo", "random"), default="demo",
        help="demo: a bright afternoon; random: light and water drawn from the seed",
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
        help="with --no-images: mean number of false boxes an image",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Make the bag and say what is in it.

    Raises:
        AerialGnssError: wrong arguments, an unreadable log, an output that exists or a full disk.
    """
    if (args.output is None) == (args.dataset is None):
        raise ConfigError("give -o BAG for a flight or --dataset FOLDER for pictures, one of them.")
    simulate_dataset.refuse_options(args, _flight_defaults())
    if args.dataset is not None:
        return simulate_dataset.run(args)
    refuse_existing(args.output)
    _check(args)
    log = read_dji_log(args.telemetry) if args.telemetry else None
    experiment = _experiment(args, log)
    about = scenario(experiment, args.noise)
    if log is not None:
        about["telemetry"] = {
            "file": log.path.name,
            "understood_as": [*log.statements, *log.guesses],
            "refused_rows": summarise_refusals(log.refused) or "none",
        }
    images = "raw" if args.raw else "jpeg"
    scene = None if args.no_images else _scene(args)
    about["images"] = "none" if scene is None else images
    total = len(experiment.frames())
    what = "simulating" if scene is None else "rendering"
    with ended_cleanly(), progress(what, total, "images") as report:
        counts = write_bag(
            args.output, experiment, scene, images=images, scenario=about, report=report
        )
    if args.json:
        print(json.dumps({"bag": str(args.output), "messages": counts, **about}, indent=2))
    else:
        messages, topics = counted(sum(counts.values()), "message"), counted(len(counts), "topic")
        print(f"made {args.output}: {messages} on {topics}")
        print("\n".join(words(about)))
    return 0


def _flight_defaults() -> dict[str, Any]:
    """Return what the options of flights are where they are not given."""
    parser = argparse.ArgumentParser(add_help=False)
    for declare in (_flight_arguments, _robot_arguments, _sensor_arguments, _image_arguments):
        declare(parser)
    return vars(parser.parse_args([]))


def _check(args: argparse.Namespace) -> None:
    generated = ("flight", "height", "tilt", "stand_off", "speed", "camera_offset")
    if args.telemetry:
        for name in generated:
            if getattr(args, name) is not None:
                option = name.replace("_", "-")
                raise ConfigError(f"--{option} has no meaning with --telemetry: the log decides.")
    elif args.start is not None:
        raise ConfigError("--start has a meaning only with --telemetry.")
    if args.robot_at and args.robots is not None:
        raise ConfigError("give --robots or --robot-at, not both.")
    if args.robots is not None and not 0 <= args.robots <= 1000:
        raise ConfigError(f"--robots must lie within 0 to 1000, not {args.robots}.")
    if args.seed < 0:
        raise ConfigError(f"--seed must not be negative, but is {args.seed}.")
    if not 10.0 <= args.field_of_view <= 120.0:
        raise ConfigError(
            f"--field-of-view must lie within 10 to 120 deg, not {args.field_of_view:g}."
        )
    if not 0.0 <= args.missed <= 1.0:
        raise ConfigError(f"--missed is a probability, 0 to 1, not {args.missed:g}.")
    if not 0.0 <= args.false_boxes <= 10_000.0:
        raise ConfigError(f"--false-boxes must lie within 0 to 10000, not {args.false_boxes:g}.")
    if args.no_images and (args.raw or args.scene != "demo"):
        option = "--raw" if args.raw else "--scene"
        raise ConfigError(f"{option} has no meaning with --no-images.")
    if not args.no_images and (args.missed or args.false_boxes):
        raise ConfigError(
            "--missed and --false-boxes need --no-images: real images need a detector."
        )


def _experiment(args: argparse.Namespace, log: DjiLog | None) -> Experiment:
    flight = _flight(args, log)
    plan = _sensors(args)
    width, height = args.size
    try:
        return Experiment(
            flight,
            default_camera(width, height, math.radians(args.field_of_view)),
            plan,
            CameraClock(args.rate, args.latency),
            robots=3 if args.robots is None else args.robots,
            places=_places(args, flight),
            swim=_swim(args),
            distractors=round(args.distractors or 0),
            detector=DetectorPlan(plan.sigmas["box_center_px"], args.missed, args.false_boxes),
            seed=args.seed,
        )
    except InputError as error:
        if log is None:
            raise
        raise InputError(f"{error} {_advice(log, flight.duration_s)}") from error


def _advice(log: DjiLog, duration_s: float) -> str:
    starts = water_seconds(log, duration_s)
    if not len(starts):
        return f"No piece of {duration_s:g} s looks at water throughout; try a shorter --duration."
    return f"From --start {starts[0]:g} it does."


def _flight(args: argparse.Namespace, log: DjiLog | None) -> Flight:
    if log is not None:
        return RecordedFlight(log, args.start or 0.0, args.duration)
    given: dict[str, Any] = {
        "kind": args.flight,
        "height_m": args.height,
        "tilt": None if args.tilt is None else math.radians(args.tilt),
        "stand_off_m": args.stand_off,
        "speed_mps": args.speed,
        "camera_offset_m": args.camera_offset,
    }
    chosen = {name: value for name, value in given.items() if value is not None}
    plan = FlightPlan(duration_s=args.duration, track=not args.fixed_gimbal, **chosen)
    return GeneratedFlight(plan, args.seed)


def _places(args: argparse.Namespace, flight: Flight) -> Any:
    if not args.robot_at:
        return None
    given = np.radians(np.array(args.robot_at))
    for place in args.robot_at:
        if not (abs(place[0]) <= 90.0 and abs(place[1]) <= 180.0):
            raise ConfigError(
                f"--robot-at {place[0]:g},{place[1]:g} is not a place on Earth; give latitude and "
                "longitude in degrees, such as 13.194,-59.641."
            )
    origin = flight.origin
    places = enu_from_geodetic(
        given[:, 0], given[:, 1], origin.altitude, origin.latitude, origin.longitude,
        origin.altitude,
    )[:, :2]  # fmt: skip
    far = float(np.linalg.norm(places, axis=1).max())
    if far > 2000.0:
        raise ConfigError(
            f"--robot-at lies {far / 1000.0:.1f} km from the flight, which is round "
            f"{math.degrees(origin.latitude):.5f}, {math.degrees(origin.longitude):.5f}."
        )
    return places


def _swim(args: argparse.Namespace) -> SwimPlan:
    speed = args.robot_speed or ((0.0,) if args.robot_at else (0.15, 0.6))
    return SwimPlan(slowest_mps=speed[0], fastest_mps=speed[-1], dives=args.dives)


def _sensors(args: argparse.Namespace) -> SensorPlan:
    plan = sensor_plan(args.noise, **dict(args.sigma))
    if not args.fix_covariance:
        return plan
    return SensorPlan(plan.noise, plan.sigmas, covariance=True)


def _scene(args: argparse.Namespace) -> Scene:
    if args.scene == "demo":
        return demo_scene(args.seed)
    return random_scene(np.random.default_rng([args.seed, 7]))
