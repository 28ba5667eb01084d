# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss simulate`: a bag of a simulated flight, or of robots under a recorded one.

With `--dataset`, labelled images instead (simulate_dataset.py).
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters.dji_log import DjiLog, read_dji_log, summarise_refusals
from aerial_gnss_ros.bags.partial import partial, refuse_existing
from aerial_gnss_ros.commands import simulate_arguments, simulate_dataset
from aerial_gnss_ros.commands.argument_types import add_rosbag_version
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic
from aerial_gnss_ros.core.values.errors import ConfigError, InputError
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.simulation.bag import write_bag
from aerial_gnss_ros.simulation.boxes import DetectorPlan
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.flight import Flight, FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.formation import Formation, together
from aerial_gnss_ros.simulation.imaging import WORKERS
from aerial_gnss_ros.simulation.recorded import RecordedFlight, water_seconds
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.scenario import scenario, words
from aerial_gnss_ros.simulation.scene import Scene, demo_scene, random_scene
from aerial_gnss_ros.simulation.sensors import SensorPlan, sensor_plan
from aerial_gnss_ros.simulation.water_photograph import WaterPhotograph
from aerial_gnss_ros.text.sentences import counted

RENDER_S_PER_PIXEL = 0.16e-6
"""Processor time of rendering and encoding: 0.15 s for 1280x720 on an EPYC core."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("-o", "--output", type=Path, help="bag to write (folder)")
    add_rosbag_version(parser)
    simulate_arguments.add_arguments(parser)
    simulate_dataset.add_arguments(parser.add_argument_group("training images"))
    parser.add_argument(
        "--seed",
        type=int,
        default=1,
        help="random seed; the same seed gives the same bytes (default 1)",
    )
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")


def run(args: argparse.Namespace) -> int:
    """Write the bag and print a summary.

    Raises:
        AerialGnssError: wrong arguments, an unreadable log, an output that exists or a full disk.
    """
    if (args.output is None) == (args.dataset is None):
        raise ConfigError("give either -o BAG for a flight or --dataset FOLDER for images.")
    simulate_dataset.refuse_options(args, simulate_arguments.defaults())
    if args.dataset is not None:
        return simulate_dataset.run(args)
    refuse_existing(args.output)
    _check(args)
    if args.duration is None:
        short = not args.no_images
        args.duration = simulate_arguments.RENDERED_S if short else simulate_arguments.DURATION_S
    if args.drones is not None:
        return _several(args)
    log = read_dji_log(args.telemetry) if args.telemetry else None
    experiment = _experiment(args, log)
    about = scenario(experiment, args.noise)
    if log is not None:
        about["telemetry"] = {
            "file": log.path.name,
            "understood_as": [*log.statements, *log.guesses],
            "refused_rows": summarise_refusals(log.refused) or "none",
        }
    with ended_cleanly():
        counts = _write(args, args.output, experiment, about)
    _print(args, [(args.output, counts, about)])
    return 0


def _several(args: argparse.Namespace) -> int:
    """Write a bag for each of several drones into one folder."""
    formation = Formation(
        args.formation or "opposite",
        args.drones,
        0.5 if args.gnss_share is None else args.gnss_share,
    )
    noises = args.drone_noise or [args.noise] * formation.count
    if len(noises) != formation.count:
        raise ConfigError(
            f"--drone-noise must be given once for each of {counted(formation.count, 'drone')}, "
            f"not {len(noises)} times."
        )
    made = together(
        lambda flight, others: _experiment_of(args, flight, others),
        _plan(args),
        formation,
        args.seed,
        [_sensors(args, noise) for noise in noises],
    )
    written: list[tuple[Path, dict[str, int], dict[str, Any]]] = []
    with ended_cleanly(), partial(args.output) as folder:
        folder.mkdir()
        for (name, experiment), noise in zip(made.items(), noises, strict=True):
            about = scenario(experiment, noise)
            about["drone"] = {
                "name": name,
                "drones": formation.count,
                "formation": formation.kind,
                "gnss_share": formation.share,
            }
            counts = _write(args, folder / name, experiment, about)
            written.append((args.output / name, counts, about))
    _print(args, written)
    return 0


def _write(
    args: argparse.Namespace, path: Path, experiment: Experiment, about: dict[str, Any]
) -> dict[str, int]:
    """Write one bag; return its messages by topic. `about` is completed."""
    images = "raw" if args.raw else "jpeg"
    scene = None if args.no_images else _scene(args)
    about["images"] = "none" if scene is None else images
    water = None
    if args.water is not None:
        width_m = simulate_arguments.WATER_M if args.water_width is None else args.water_width
        water = WaterPhotograph(read_image(args.water), width_m)
        about["water"] = {"photograph": args.water.name, "width_m": width_m}
    total = len(experiment.frames())
    what = "simulating" if scene is None else "rendering"
    if scene is not None:
        print(_how_long(total, args.size), file=sys.stderr)
    with progress(what, total, "images") as report:
        return write_bag(
            path,
            experiment,
            scene,
            images=images,
            scenario=about,
            report=report,
            version=args.rosbag_version,
            water=water,
        )


def _print(
    args: argparse.Namespace, written: list[tuple[Path, dict[str, int], dict[str, Any]]]
) -> None:
    """Print what was written: a bag for each drone, its messages by topic, its scenario."""
    if args.json:
        found = [{"bag": str(path), "messages": counts, **about} for path, counts, about in written]
        print(json.dumps(found[0] if args.drones is None else {"drones": found}, indent=2))
        return
    for path, counts, about in written:
        messages, topics = counted(sum(counts.values()), "message"), counted(len(counts), "topic")
        print(f"made {path}: {messages} on {topics}")
        print("\n".join(words(about)))


def _how_long(images: int, size: tuple[int, int]) -> str:
    """Return a sentence on what takes long, before it does."""
    seconds = images * size[0] * size[1] * RENDER_S_PER_PIXEL / min(WORKERS, os.cpu_count() or 1)
    return (
        f"Rendering {counted(images, 'image')} of {size[0]}x{size[1]} takes about "
        f"{math.ceil(seconds / 5.0) * 5} s on this machine's processor, and more where it is busy. "
        "A smaller --size or --rate takes less; --no-images, with the boxes of a simulated "
        "detector, takes seconds."
    )


def _check(args: argparse.Namespace) -> None:
    generated = ("flight", "height", "tilt", "stand_off", "speed", "camera_offset")
    if args.telemetry:
        for name in generated:
            if getattr(args, name) is not None:
                option = name.replace("_", "-")
                raise ConfigError(f"--{option} cannot be used with --telemetry: the log decides.")
    elif args.start is not None:
        raise ConfigError("--start applies only with --telemetry.")
    if args.robot_at and args.robots is not None:
        raise ConfigError("give --robots or --robot-at, not both.")
    _check_reference(args)
    _check_formation(args)
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
    _check_images(args)


def _check_images(args: argparse.Namespace) -> None:
    if args.water_width is not None and args.water is None:
        raise ConfigError("--water-width applies only with --water.")
    if args.no_images and (args.raw or args.scene != "demo" or args.water):
        option = "--raw" if args.raw else "--water" if args.water else "--scene"
        raise ConfigError(f"{option} cannot be used with --no-images.")
    if not args.no_images and (args.missed or args.false_boxes):
        raise ConfigError(
            "--missed and --false-boxes need --no-images: real images need a detector."
        )


def _check_formation(args: argparse.Namespace) -> None:
    if args.drones is None:
        for name in ("formation", "gnss_share", "drone_noise"):
            if getattr(args, name) is not None:
                raise ConfigError(f"--{name.replace('_', '-')} applies only with --drones.")
    elif args.telemetry:
        raise ConfigError("--drones cannot be used with --telemetry: the log is of one drone.")


def _check_reference(args: argparse.Namespace) -> None:
    if args.reference is not None and not 0.001 <= args.reference <= 100.0:
        raise ConfigError(f"--reference must lie within 0.001 to 100 m, not {args.reference:g}.")
    if args.reference is not None and args.robot_at:
        raise ConfigError("--reference cannot be used with --robot-at: its position is drawn.")


def _experiment(args: argparse.Namespace, log: DjiLog | None) -> Experiment:
    flight = _flight(args, log)
    try:
        return _experiment_of(args, flight)
    except InputError as error:
        if log is None:
            raise
        raise InputError(f"{error} {_advice(log, flight.duration_s)}") from error


def _experiment_of(
    args: argparse.Namespace, flight: Flight, others: Sequence[Flight] = ()
) -> Experiment:
    """Return the experiment of a flight; robots are placed where `others` see them, too."""
    plan = _sensors(args, args.noise)
    width, height = args.size
    return Experiment(
        flight,
        default_camera(width, height, math.radians(args.field_of_view)),
        plan,
        CameraClock(args.rate, args.latency),
        robots=(3 if args.robots is None else args.robots) + (args.reference is not None),
        places=_places(args, flight),
        swim=_swim(args),
        distractors=round(args.distractors or 0),
        detector=DetectorPlan(plan.sigmas["box_center_px"], args.missed, args.false_boxes),
        survey_m=args.reference or 0.0,
        seed=args.seed,
        others=others,
    )


def _advice(log: DjiLog, duration_s: float) -> str:
    starts = water_seconds(log, duration_s)
    if not len(starts):
        return f"No part of {duration_s:g} s sees water throughout; try a shorter --duration."
    return f"With --start {starts[0]:g} it does."


def _flight(args: argparse.Namespace, log: DjiLog | None) -> Flight:
    if log is not None:
        return RecordedFlight(log, args.start or 0.0, args.duration)
    return GeneratedFlight(_plan(args), args.seed)


def _plan(args: argparse.Namespace) -> FlightPlan:
    """Return the plan of a generated flight."""
    given: dict[str, Any] = {
        "kind": args.flight,
        "height_m": args.height,
        "tilt": None if args.tilt is None else math.radians(args.tilt),
        "stand_off_m": args.stand_off,
        "speed_mps": args.speed,
        "camera_offset_m": args.camera_offset,
    }
    chosen = {name: value for name, value in given.items() if value is not None}
    return FlightPlan(duration_s=args.duration, track=not args.fixed_gimbal, **chosen)


def _places(args: argparse.Namespace, flight: Flight) -> Any:
    if not args.robot_at:
        return None
    given = np.radians(np.array(args.robot_at))
    for place in args.robot_at:
        if not (abs(place[0]) <= 90.0 and abs(place[1]) <= 180.0):
            raise ConfigError(
                f"--robot-at {place[0]:g},{place[1]:g} is not on Earth; give latitude and "
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
            f"--robot-at is {far / 1000.0:.1f} km from the flight, which is near "
            f"{math.degrees(origin.latitude):.5f}, {math.degrees(origin.longitude):.5f}."
        )
    return places


def _swim(args: argparse.Namespace) -> SwimPlan:
    speed = args.robot_speed or ((0.0,) if args.robot_at else (0.15, 0.6))
    return SwimPlan(
        slowest_mps=speed[0],
        fastest_mps=speed[-1],
        dives=args.dives,
        beacons=int(args.reference is not None),
        beacon_class="beacon" if args.no_images else "",
        models=args.robot_model,
    )


def _sensors(args: argparse.Namespace, noise: str) -> SensorPlan:
    plan = sensor_plan(noise, **dict(args.sigma))
    if not args.fix_covariance:
        return plan
    return SensorPlan(plan.noise, plan.sigmas, covariance=True)


def _scene(args: argparse.Namespace) -> Scene:
    if args.scene == "demo":
        return demo_scene(args.seed)
    return random_scene(np.random.default_rng([args.seed, 7]))
