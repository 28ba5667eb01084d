# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Writes the labels of a session as a data set in YOLO's layout, for `aerial-gnss train`."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aerial_gnss_ros.bags.partial import partial
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.teaching.session import Session
from aerial_gnss_ros.teaching.tracks import clipped
from aerial_gnss_ros.text.sentences import counted
from aerial_gnss_ros.training.label_lines import as_text
from aerial_gnss_ros.training.layout import write_data_file

FOLDER = "dataset"
ASIDE = 0.2
"""Share of the recording, its end, that is kept aside for scoring (val)."""
FEW = 20
"""Boxes below which training is not worth its time."""


@dataclass(frozen=True)
class Written:
    """What was written.

    Attributes:
        images: number of images by split.
        boxes: number of boxes by class.
        left_out: number of frames with a robot that is unsure or unknown.
    """

    images: dict[str, int]
    boxes: dict[str, int]
    left_out: int


def write_dataset(session: Session, folder: Path) -> Written:
    """Write the frames in which every robot is known; an earlier data set is replaced.

    A frame with a robot that is unsure is left out: a missing box would teach to miss it.

    Args:
        session: with labels.
        folder: of the project.

    Raises:
        InputError: no frame has a label.
        OutputError: the disk is full.
    """
    names = list(dict.fromkeys(session.project.classes.values()))
    images = {"train": 0, "val": 0}
    boxes = dict.fromkeys(names, 0)
    count, left_out = len(session.recording), 0
    last_of_train = round((1.0 - ASIDE) * count)
    fresh, final = folder / f"{FOLDER}.new", folder / FOLDER
    shutil.rmtree(fresh, ignore_errors=True)  # left by a killed run
    with partial(fresh) as place:
        for split in images:
            (place / "images" / split).mkdir(parents=True)
            (place / "labels" / split).mkdir(parents=True)
        width, height = session.recording.size
        for frame, file in enumerate(session.recording.files):
            labels = session.labels(frame)
            if labels is None:
                left_out += 1
                continue
            split = "train" if frame < last_of_train else "val"
            numbers = [names.index(session.project.classes[robot]) for robot, _ in labels]
            rows = [clipped(track.box, session.recording.size) for _, track in labels]
            text = as_text(numbers, [np.asarray(row) for row in rows], width, height)
            shutil.copyfile(file, place / "images" / split / file.name)
            target = place / "labels" / split / f"{file.stem}.txt"
            target.write_text(text, encoding="ascii")
            images[split] += 1
            for number in numbers:
                boxes[names[number]] += 1
        if not sum(boxes.values()):
            raise InputError(f"no frame has a label that is sure; {_why(session)}")
        splits = {split: f"images/{split}" for split, number in images.items() if number}
        splits.setdefault("train", "images/train")
        write_data_file(place / "data.yaml", names, splits)
    if final.exists():
        old = folder / f".{FOLDER}.old"
        shutil.rmtree(old, ignore_errors=True)
        final.rename(old)
        fresh.rename(final)
        shutil.rmtree(old, ignore_errors=True)
    else:
        fresh.rename(final)
    return Written(images, boxes, left_out)


def _why(session: Session) -> str:
    """Return what to do where no label is sure."""
    for one, other, count in session.twins():
        return (
            f"{one} and {other} have the same box in {counted(count, 'frame')}: if they are one "
            "robot, take one of them back (--undo, or U on the page), else draw a box round each."
        )
    for question in session.questions():
        last = f" to {question.until}" if question.until > question.frame else ""
        return (
            f"answer the questions first, such as whether {question.robot} is visible in frame "
            f"{question.frame}{last}."
        )
    return "every robot is marked as absent; click one where it is visible."
