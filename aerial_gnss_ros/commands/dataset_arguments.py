# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Arguments that name a labelled data set, and its inspection beforehand."""

from __future__ import annotations

import argparse
from pathlib import Path

from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.training.inspection import Inspection, inspect
from aerial_gnss_ros.training.layout import open_dataset


def add_dataset_arguments(parser: argparse.ArgumentParser, optional: bool = False) -> None:
    """Add the data set and the meaning of images without labels."""
    parser.add_argument(
        "dataset",
        type=Path,
        nargs="?" if optional else None,
        metavar="DATASET",
        help="folder in YOLO's layout (data.yaml, images/, labels/), or its data.yaml",
    )
    parser.add_argument(
        "--unlabelled", choices=("refuse", "empty"), default="refuse",
        help="an image without a label file: an error (default), or one without robots",
    )  # fmt: skip


def inspected(args: argparse.Namespace, needed: tuple[str, ...]) -> Inspection:
    """Return the data set that the arguments name, after an inspection without errors.

    Raises:
        InputError: it is unreadable or has errors; each file is named.
    """
    dataset = open_dataset(args.dataset)
    total = sum(len(images) for images in dataset.images.values())
    with progress("looking through", total, "images") as report:
        found = inspect(
            dataset,
            unlabelled_is_empty=args.unlabelled == "empty",
            needed=needed,
            report=report,
        )
    found.refuse_problems()
    return found
