# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Augments a data set in YOLO's layout: several variants of each training image."""

from __future__ import annotations

import json
import shutil
import zlib
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from aerial_gnss_ros import __version__
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.detection.images import read_image, write_jpeg
from aerial_gnss_ros.simulation.workers import shared
from aerial_gnss_ros.training.contact_sheet import SHEET, write_contact_sheet
from aerial_gnss_ros.training.inspection import Example, Inspection
from aerial_gnss_ros.training.label_lines import as_text
from aerial_gnss_ros.training.layout import write_data_file
from aerial_gnss_ros.training.naming import path_key, unique_names
from aerial_gnss_ros.training.phases import Phase, members
from aerial_gnss_ros.training.variants import Recipe, make_variant

AUGMENTED = "train"
"""Only the training split is augmented: held-out images stay unchanged."""
META = "meta.csv"
_KILLED = (
    "a process of the augmentation was killed, probably because memory ran out; try again with "
    "fewer --processes."
)
SUMMARY = "augmentation.json"


@dataclass(frozen=True)
class Plan:
    """Settings of an augmentation.

    Attributes:
        variants: of each image.
        recipe: how each is made.
        seed: same seed, same bytes, whatever the number of processes.
        keep_originals: whether to copy the original images as well.
        quality: of the JPEGs, 1 to 100.
        shows: key of phases.SHOWS: selects the training images.

    Raises:
        ConfigError: a value out of its range.
    """

    variants: int = 10
    recipe: Recipe = field(default_factory=Recipe)
    seed: int = 0
    keep_originals: bool = False
    quality: int = 95
    shows: str = "all"

    def __post_init__(self) -> None:
        for name, value, low, high in (
            ("variants", self.variants, 1, 10_000),
            ("seed", self.seed, 0, 2**63 - 1),
            ("quality", self.quality, 1, 100),
        ):
            if not low <= value <= high:
                raise ConfigError(f"{name} must lie within {low} to {high}, but is {value}.")


@dataclass(frozen=True)
class Made:
    """Counts of an augmentation.

    Attributes:
        images: augmented images written.
        dropped: discarded variants, because a box's centre left the image.
        boxes: in the augmented images.
        copied: images of other splits, and originals.
    """

    images: int
    dropped: int
    boxes: int
    copied: int


def augment(
    source: Inspection,
    folder: Path,
    plan: Plan,
    processes: int = 1,
    report: Callable[[int], None] | None = None,
) -> Made:
    """Write images/, labels/, data.yaml, a contact sheet and a summary.

    Args:
        source: a data set without problems.
        folder: where to; must not exist.
        plan: what to make.
        processes: number of worker processes; does not change the result.
        report: called with the number of training images done.

    Raises:
        ConfigError: the plan selects no image.
        OutputError: one of the processes was killed.
    """
    folder.mkdir(parents=True)
    taken = chosen(source, plan)
    copied = 0
    for split, examples in {**source.examples, AUGMENTED: taken}.items():
        (folder / "images" / split).mkdir(parents=True)
        (folder / "labels" / split).mkdir(parents=True)
        if split != AUGMENTED or plan.keep_originals:
            # Variants get a number at the end, which keeps names unique.
            end = "_original" if split == AUGMENTED else ""
            for example, name in zip(examples, _names(examples, source), strict=True):
                _copy(example, folder, split, f"{name}{end}")
            copied += len(examples)
    jobs = [
        _Job(e.image, e.boxes, e.classes, name, path_key(e.image, source.dataset), folder, plan)
        for e, name in zip(taken, _names(taken, source), strict=True)
    ]
    images = boxes = 0
    for done, (made, held) in enumerate(shared(_run, jobs, processes, _KILLED), start=1):
        images, boxes = images + made, boxes + held
        if report is not None:
            report(done)
    splits = {split: f"images/{split}" for split in source.examples}
    write_data_file(folder / "data.yaml", source.dataset.names, splits)
    _copy_meta(source, folder)
    result = Made(images, len(jobs) * plan.variants - images, boxes, copied)
    write_contact_sheet(folder, AUGMENTED, [job.stem for job in jobs], folder / SHEET)
    summary = {
        "made": asdict(result),
        "plan": asdict(plan),
        "source_fingerprint": source.fingerprint(),
        "versions": {"aerial_gnss_ros": __version__, "opencv": cv2.__version__},
    }
    (folder / SUMMARY).write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    return result


def chosen(source: Inspection, plan: Plan) -> list[Example]:
    """Return the selected training images.

    Raises:
        ConfigError: no image has the selected number of robots.
    """
    examples = source.examples[AUGMENTED]
    return examples if plan.shows == "all" else members(Phase(plan.shows, 1), examples)


@dataclass(frozen=True)
class _Job:
    image: Path
    boxes: Any  # (n, 4) relative to the image
    classes: Any
    stem: str
    key: str
    folder: Path
    plan: Plan


def _names(examples: list[Example], source: Inspection) -> list[str]:
    return unique_names([example.image for example in examples], source.dataset)


def _run(job: _Job) -> tuple[int, int]:
    """Write the variants of one image; how many, and their boxes."""
    image = read_image(job.image)
    size = np.array([image.shape[1], image.shape[0]], dtype=np.float64)
    boxes = job.boxes * np.tile(size, 2)
    made = held = 0
    for number in range(job.plan.variants):
        # By its path, so that an image's variants do not depend on the rest of the set.
        seeds = [job.plan.seed, zlib.crc32(job.key.encode()), number]
        variant = make_variant(image, boxes, job.plan.recipe, np.random.default_rng(seeds))
        if variant is None:
            continue
        name = f"{job.stem}_{number:02d}"
        path = job.folder / "images" / AUGMENTED / f"{name}.jpg"
        write_jpeg(path, variant.image, job.plan.quality)
        height, width = variant.image.shape[:2]
        text = as_text(job.classes.tolist(), list(variant.boxes), width, height)
        (job.folder / "labels" / AUGMENTED / f"{name}.txt").write_text(text, encoding="ascii")
        made, held = made + 1, held + len(boxes)
    return made, held


def _copy(example: Example, folder: Path, split: str, stem: str) -> None:
    suffix = example.image.suffix.lower()
    shutil.copyfile(example.image, folder / "images" / split / f"{stem}{suffix}")
    labels = folder / "labels" / split / f"{stem}.txt"
    if example.labels.is_file():
        shutil.copyfile(example.labels, labels)
    else:
        labels.touch()


def _copy_meta(source: Inspection, folder: Path) -> None:
    """Keep a simulation's record of the images that are not augmented."""
    meta = source.dataset.root / META
    if not meta.is_file():
        return
    head, *rows = meta.read_text(encoding="utf-8").splitlines(keepends=True)
    column = head.strip().split(",").index("split")
    kept = [row for row in rows if row.split(",")[column] != AUGMENTED]
    (folder / META).write_text("".join([head, *kept]), encoding="utf-8")
