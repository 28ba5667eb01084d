# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss simulate --dataset`: labelled images for training or testing a detector."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from aerial_gnss_ros.commands.argument_types import numbers
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.dataset import generate
from aerial_gnss_ros.simulation.sample_source import RENDERERS
from aerial_gnss_ros.simulation.samples import DatasetConfig
from aerial_gnss_ros.simulation.staging import Variety

COUNT = 1000
CROP_PX = 320
_USUAL = Variety()
_SAMPLES = DatasetConfig({}).samples
_OCCUPIED = DatasetConfig({}).occupied
_OCCUPIED_FRAMES = 0.9


def add_arguments(group: Any) -> None:
    """Declare the arguments of data sets; all are None unless given."""
    _add_kind(group)
    _add_ranges(group)
    _add_things(group)


def _add_kind(group: Any) -> None:
    group.add_argument(
        "--dataset", type=Path, metavar="FOLDER",
        help="write labelled images of random scenes, in YOLO's layout, instead of a bag",
    )  # fmt: skip
    group.add_argument("--count", type=int, metavar="N", help=f"number of images (default {COUNT})")
    group.add_argument(
        "--val",
        type=int,
        metavar="N",
        help="number of validation images in addition (default: a tenth)",
    )
    group.add_argument(
        "--crop", type=int, metavar="PX", help=f"side of the images, px (default {CROP_PX})"
    )
    group.add_argument(
        "--whole-frames", action="store_true", default=None,
        help=
                "split `test`, for scoring detectors: frames of --size, including small and "
                "faint robots",
    )  # fmt: skip
    group.add_argument(
        "--renderer",
        choices=RENDERERS,
        help='blender needs `pip install ".[blender]"` in the source folder (default fast)',
    )
    group.add_argument(
        "--ranges", metavar="NAME",
        help=
                "with --renderer blender: appearance: train (default), or unseen, which shares "
                "no appearance with it",
    )  # fmt: skip
    group.add_argument(
        "--samples", type=int, metavar="N",
        help=f"with --renderer blender: samples per pixel (default {_SAMPLES})",
    )  # fmt: skip
    group.add_argument(
        "--processes", type=int, metavar="N", help="number of renderers at a time (default 1)"
    )
    group.add_argument(
        "--occupied", type=float, metavar="SHARE",
        help=
                f"share of the images with robots (default {_OCCUPIED:g}, {_OCCUPIED_FRAMES:g} of "
                "whole frames)",
    )  # fmt: skip


def _add_ranges(group: Any) -> None:
    for name, value, text in (
        ("heights", _USUAL.height_m, "height above the water, m"),
        ("tilts", (10.0, 90.0), "angle of the camera below the horizon, deg"),
        ("lengths", _USUAL.long_px, "length of robots in the image, px"),
        (
            "depths",
            _USUAL.depth_m,
            "depth of robots below the surface, m; negative values float high",
        ),
    ):
        usual = ",".join(f"{v:g}" for v in value)
        group.add_argument(
            f"--{name}", type=numbers(2), metavar="LOW,HIGH",
            help=f"{text} (default {usual}; write --{name}={usual})",
        )  # fmt: skip
    group.add_argument(
        "--winds", type=numbers(2), metavar="LOW,HIGH",
        help="wind speed, m/s; foam from about 4 (default: mostly 2 to 9)",
    )  # fmt: skip


def _add_things(group: Any) -> None:
    group.add_argument(
        "--extra-robots", type=float, metavar="MEAN",
        help=f"number of robots beside the first (default {_USUAL.extra_robots:g})",
    )  # fmt: skip
    group.add_argument(
        "--flotsam", type=float, metavar="MEAN",
        help=
                "mean number of further objects of random shape and colour (default "
                f"{_USUAL.flotsam:g})",
    )  # fmt: skip
    group.add_argument(
        "--distractors", type=float, metavar="MEAN",
        help=
                "mean number of buoys, birds, boats, swimmers, turtles, weed and rubbish in an "
                f"image (default {_USUAL.distractors:g}); in a flight their total number, placed "
                "clear of the robots' paths (default 0)",
    )  # fmt: skip


def refuse_options(args: argparse.Namespace, flight: Mapping[str, Any]) -> None:
    """Refuse options that apply only to the other kind of output.

    Args:
        args: all of them.
        flight: options of flights with their defaults.

    Raises:
        ConfigError: names the option.
    """
    if args.dataset is not None:
        if args.size != flight["size"] and not args.whole_frames:
            raise ConfigError("--size of images applies only with --whole-frames.")
        for name in sorted(flight.keys() - {"size", "robot_model"}):
            if getattr(args, name) != flight[name]:
                raise ConfigError(
                    f"{_option(name)} cannot be used with --dataset, which has no flight."
                )
        return
    given = vars(args)
    for name in (
        "count", "val", "crop", "whole_frames", "renderer", "ranges", "samples", "processes",
        "heights", "tilts", "lengths", "depths", "winds", "occupied", "extra_robots", "flotsam",
    ):  # fmt: skip
        if given[name] is not None:
            raise ConfigError(f"{_option(name)} applies only with --dataset.")
    if args.distractors is not None and not 0 <= args.distractors <= 100:
        raise ConfigError(f"--distractors must lie within 0 to 100, not {args.distractors:g}.")
    if args.no_images and args.distractors:
        raise ConfigError("--distractors need images; leave out --no-images.")


def _option(name: str) -> str:
    return "--" + name.replace("_", "-")


def run(args: argparse.Namespace) -> int:
    """Write the images and print a summary.

    Raises:
        AerialGnssError: wrong arguments, an output that exists, a full disk, no such renderer.
    """
    config = _config(args)
    total = sum(config.counts.values())
    with ended_cleanly(), progress("rendering", total, "pictures") as report:
        generate(args.dataset, config, args.processes or 1, lambda done, _: report(done))
    about = {
        "dataset": str(args.dataset),
        "data": str(args.dataset / "data.yaml"),
        "pictures": config.counts,
        "renderer": config.renderer,
        "seed": config.seed,
    }
    if args.json:
        print(json.dumps(about, indent=2))
    else:
        counts = ", ".join(f"{count} {split}" for split, count in config.counts.items())
        print(f"made {args.dataset}: {counts} images, {config.renderer} renderer, seed {args.seed}")
    return 0


def _config(args: argparse.Namespace) -> DatasetConfig:
    if args.seed < 0:
        raise ConfigError(f"--seed must not be negative, but is {args.seed}.")
    for name, least in (("count", 1), ("val", 0), ("processes", 1), ("samples", 1)):
        value = getattr(args, name)
        if value is not None and value < least:
            raise ConfigError(f"--{name} must be {least} or more, not {value}.")
    for name in ("ranges", "samples"):
        if getattr(args, name) is not None and args.renderer != "blender":
            raise ConfigError(f"--{name} applies only with --renderer blender.")
    if args.occupied is not None and not 0.0 <= args.occupied <= 1.0:
        raise ConfigError(f"--occupied is a share, 0 to 1, not {args.occupied:g}.")
    usually = _OCCUPIED_FRAMES if args.whole_frames else _OCCUPIED
    count = COUNT if args.count is None else args.count
    common: dict[str, Any] = {
        "seed": args.seed,
        "occupied": usually if args.occupied is None else args.occupied,
        "variety": _variety(args),
        "renderer": args.renderer or "fast",
        "ranges": args.ranges or "train",
        "samples": args.samples or _SAMPLES,
    }
    if args.whole_frames:
        if args.crop is not None or args.val is not None:
            raise ConfigError("--crop and --val cannot be used with --whole-frames.")
        counts = {"test": count}
        return DatasetConfig(counts, None, image=args.size, prune=False, **common)
    val = count // 10 if args.val is None else args.val
    side = CROP_PX if args.crop is None else args.crop
    return DatasetConfig({"train": count, "val": val}, (side, side), **common)


def _variety(args: argparse.Namespace) -> Variety:
    if len(args.robot_model) > 1:
        raise ConfigError(
            f"--dataset renders robots of one model, not of {', '.join(args.robot_model)}; make a "
            "data set of each."
        )
    chosen: dict[str, Any] = {"robot_model": args.robot_model[0]}
    for option, field, least, most in (
        ("heights", "height_m", 1.0, 500.0),
        ("depths", "depth_m", -0.1, 5.0),
        ("lengths", "long_px", 4.0, 700.0),
        ("tilts", "tilt_deg", 5.0, 90.0),
        ("winds", "wind_mps", 0.5, 15.0),
    ):
        given = getattr(args, option)
        if given is None:
            continue
        low, high = given
        if not least <= low <= high <= most:
            raise ConfigError(
                f"--{option} must be LOW,HIGH within {least:g} to {most:g}, not {low:g},{high:g}."
            )
        span = (90.0 - high, 90.0 - low) if option == "tilts" else (low, high)
        chosen[field] = span
        if option == "lengths":
            chosen["usual_long_px"] = span
    for option in ("extra_robots", "distractors", "flotsam"):
        mean = getattr(args, option)
        if mean is None:
            continue
        if not 0.0 <= mean <= 10.0:
            raise ConfigError(f"{_option(option)} must lie within 0 to 10, not {mean:g}.")
        chosen[option] = mean
    return replace(_USUAL, **chosen)
