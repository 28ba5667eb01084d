# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss augment`: several variants of each training image, with their boxes."""

from __future__ import annotations

import argparse
import json
import os
from dataclasses import asdict
from pathlib import Path

from aerial_gnss_ros.bags.partial import partial, refuse_existing
from aerial_gnss_ros.commands.argument_types import size
from aerial_gnss_ros.commands.dataset_arguments import add_dataset_arguments, inspected
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.text.sentences import counted
from aerial_gnss_ros.training.augment import AUGMENTED, Plan, augment, chosen
from aerial_gnss_ros.training.contact_sheet import SHEET
from aerial_gnss_ros.training.phases import SHOWS
from aerial_gnss_ros.training.variants import PROBABILITIES, SIDE, Recipe


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    plan = Plan()
    add_dataset_arguments(parser)
    parser.add_argument("-o", "--output", type=Path, required=True, help="new folder")
    parser.add_argument(
        "--variants", type=int, default=plan.variants, metavar="N",
        help=f"variants of each training image (default {plan.variants})",
    )  # fmt: skip
    defaults = ", ".join(f"{name}={value:g}" for name, value in PROBABILITIES.items())
    parser.add_argument(
        "--probability", type=_probability, action="append", default=[], metavar="NAME=P",
        help=f"probability of an operation, 0 disables it; may be repeated (default {defaults})",
    )  # fmt: skip
    parser.add_argument(
        "--size", type=size, default=(SIDE, SIDE), metavar="WxH",
        help=f"crop larger images to this size, px (default {SIDE}x{SIDE})",
    )  # fmt: skip
    parser.add_argument(
        "--keep-originals", action="store_true", help="copy the original images as well"
    )
    parser.add_argument(
        "--shows", choices=tuple(SHOWS), default=plan.shows,
        help="only training images with one robot (or none), or with several (or none): the "
        "paper's two sets (default all; train splits them itself)",
    )  # fmt: skip
    parser.add_argument(
        "--quality",
        type=int,
        default=plan.quality,
        help=f"quality of the JPEGs (default {plan.quality})",
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=plan.seed,
        help="* random seed; the same seed gives the same bytes",
    )
    cores = len(os.sched_getaffinity(0))
    parser.add_argument(
        "--processes", type=int, default=cores, metavar="N",
        help="worker processes (default: one per core)",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")


def run(args: argparse.Namespace) -> int:
    """Write the augmented data set and print a summary.

    Raises:
        AerialGnssError: wrong arguments, a data set with errors, an output that exists.
    """
    refuse_existing(args.output)
    if not 1 <= args.processes <= 1024:
        raise ConfigError(f"--processes must lie within 1 to 1024, not {args.processes}.")
    recipe = Recipe({**PROBABILITIES, **dict(args.probability)}, args.size)
    plan = Plan(
        args.variants, recipe, args.seed, args.keep_originals, args.quality, args.shows
    )  # fmt: skip
    with ended_cleanly(), partial(args.output) as folder:
        source = inspected(args, needed=(AUGMENTED,))
        total = len(chosen(source, plan))
        with progress("augmenting", total, "images") as report:
            made = augment(source, folder, plan, args.processes, report)
    if args.json:
        print(json.dumps({"dataset": str(args.output), **asdict(made)}, indent=2))
        return 0
    print(
        f"made {args.output}: {counted(made.images, 'variant')} of {counted(total, 'image')}, "
        f"{counted(made.boxes, 'box')}; {counted(made.dropped, 'variant')} dropped because a "
        f"box's centre left the image; {counted(made.copied, 'image')} copied unchanged."
    )
    print(f"look at {args.output / SHEET}")
    return 0


def _probability(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=P, such as rotation=0.5") from error
