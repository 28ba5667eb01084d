# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Inspects a data set before use: every file, every line, and duplicates across splits."""

from __future__ import annotations

import hashlib
import io
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image as PillowImage

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.image_header import MAX_PIXELS, read_header, refuse_large
from aerial_gnss_ros.text.sentences import counted
from aerial_gnss_ros.training.label_lines import parse
from aerial_gnss_ros.training.labelled import ENDINGS
from aerial_gnss_ros.training.layout import NOT_LABELS, Dataset, image_files, label_file

MOST_SAID = 100
_ORIENTATION = 0x0112  # EXIF


class DatasetError(InputError):
    """A data set has errors; the message names each file."""


@dataclass(frozen=True)
class Problem:
    """An error in a file.

    Attributes:
        file: which.
        what: in words, without a full stop.
        line: of the file, from 1; 0: the whole file.
    """

    file: Path
    what: str
    line: int = 0

    def __str__(self) -> str:
        return f"{self.file}{f', line {self.line}' if self.line else ''}: {self.what}"


@dataclass(frozen=True)
class Example:
    """A valid labelled image.

    Attributes:
        image: the file.
        labels: its label file, which is missing where `unlabelled` images count as empty.
        size: width, height, px.
        classes: (n,) numbers of the classes.
        boxes: (n, 4) centre x, y, width, height, relative to the image.
        digest: SHA-256 of image and labels as they lie on the disk.
        pixels: SHA-256 of the pixels alone, equal for the same picture in another file.
    """

    image: Path
    labels: Path
    size: tuple[int, int]
    classes: NDArray[np.int64]
    boxes: NDArray[np.float64]
    digest: str
    pixels: str


@dataclass
class Inspection:
    """Result of an inspection.

    Attributes:
        dataset: the data set.
        examples: the valid images of each split.
        problems: the errors.
    """

    dataset: Dataset
    examples: dict[str, list[Example]] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    def fingerprint(self) -> str:
        """Return SHA-256 over classes, and names and contents of all images and labels."""
        total = hashlib.sha256("\n".join(self.dataset.names).encode())
        for split, examples in sorted(self.examples.items()):
            for example in sorted(examples, key=lambda example: example.image):
                name = _relative(example.image, self.dataset.root)
                total.update(f"\n{split} {name} {example.digest}".encode())
        return total.hexdigest()

    def refuse_problems(self) -> None:
        """Raise DatasetError where there are any, with a line for each."""
        if not self.problems:
            return
        count = len(self.problems)
        lines = [f"  {problem}" for problem in self.problems[:MOST_SAID]]
        if count > MOST_SAID:
            lines.append(f"  and {count - MOST_SAID} more")
        raise DatasetError(
            f"{self.dataset.file} describes a data set with {counted(count, 'error')}; no work "
            "was done:\n" + "\n".join(lines)
        )


def inspect(
    dataset: Dataset,
    *,
    unlabelled_is_empty: bool = False,
    needed: tuple[str, ...] = ("train", "val"),
    report: Callable[[int], None] | None = None,
) -> Inspection:
    """Return the content of a data set and all its errors.

    Args:
        dataset: as its data.yaml describes it.
        unlabelled_is_empty: whether an image without a label file shows no robot. Otherwise it is
            an error: a forgotten label teaches a network to overlook a robot.
        needed: splits that must have images.
        report: called with the number of images inspected.
    """
    found = Inspection(dataset)
    done = 0
    for split, images in dataset.images.items():
        found.examples[split] = examples = []
        if not images:
            found.problems.append(Problem(dataset.file, f"{split} has no images"))
        found.problems += _same_stem(images)
        for image in images:
            try:
                examples.append(_example(image, dataset, unlabelled_is_empty, found.problems))
            except InputError as error:
                found.problems.append(Problem(image, str(error).rstrip(".")))
            done += 1
            if report is not None:
                report(done)
        found.problems += _without_image(dataset, split)
    for split in needed:
        if split not in dataset.images:
            found.problems.append(Problem(dataset.file, f"it has no {split}"))
    found.problems += _duplicates(found.examples)
    return found


def _example(image: Path, dataset: Dataset, may_lack: bool, problems: list[Problem]) -> Example:
    if not image.is_file():
        raise InputError("the image is missing")
    content = image.read_bytes()
    size, pixels = _decode(content)
    labels = label_file(image)
    text = b""
    if labels.is_file():
        text = labels.read_bytes()
    elif not may_lack:
        raise InputError(
            f"it has no label file {labels}; write an empty one if there is no robot, or declare "
            "such images empty (--unlabelled empty)"
        )
    rows = []
    for number, line in enumerate(text.decode("utf-8", errors="replace").splitlines(), start=1):
        if line.strip():
            try:
                row = parse(line, len(dataset.names))
            except InputError as error:
                problems.append(Problem(labels, str(error), number))
                continue
            if row in rows:
                problems.append(Problem(labels, "the same box occurs twice", number))
            rows.append(row)
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    digest = hashlib.sha256(hashlib.sha256(content).digest() + text).hexdigest()
    classes = table[:, 0].astype(np.int64)
    return Example(image, labels, size, classes, table[:, 1:], digest, pixels)


def _decode(content: bytes) -> tuple[tuple[int, int], str]:
    if not content:
        raise InputError("the file is empty")
    header = read_header(content)
    if header is None:
        raise InputError("it is not an image, despite its name")
    refuse_large(header.width, header.height, MAX_PIXELS, "")
    try:
        with warnings.catch_warnings(), PillowImage.open(io.BytesIO(content)) as picture:
            warnings.simplefilter("ignore", PillowImage.DecompressionBombWarning)
            orientation = picture.getexif().get(_ORIENTATION, 1)
            rgb = picture.convert("RGB")  # reads it whole, so a cut file is noticed
    except Exception as error:  # Pillow raises arbitrary exceptions on damage
        said = " ".join(str(error).split())
        raise InputError(f"the image cannot be read ({said or 'damaged'})") from error
    if orientation != 1:
        raise InputError(
            f"it is stored rotated (EXIF orientation {orientation}), which label tools treat "
            "differently: save it upright, and check its labels"
        )
    if min(rgb.size) < 10:
        raise InputError(f"it is only {rgb.size[0]} x {rgb.size[1]} px")
    shape = f"{rgb.size}".encode()
    return rgb.size, hashlib.sha256(shape + rgb.tobytes()).hexdigest()


def _same_stem(images: tuple[Path, ...]) -> Iterator[Problem]:
    first: dict[Path, Path] = {}
    for image in images:
        other = first.setdefault(label_file(image), image)
        if other != image:
            yield Problem(image, f"it shares its label file with {other}")


def _without_image(dataset: Dataset, split: str) -> Iterator[Problem]:
    for folder in dataset.folders[split]:
        if folder.parts.count("images") == 0:
            continue
        expected = {label_file(image) for image in image_files(folder)}
        labels = label_file(folder / "x").parent
        for file in sorted(labels.rglob("*.txt")):
            if file not in expected and file.name not in NOT_LABELS:
                yield Problem(file, f"its image is missing ({', '.join(ENDINGS)})")


def _duplicates(examples: dict[str, list[Example]]) -> Iterator[Problem]:
    first: dict[str, tuple[str, Path]] = {}
    for split, members in examples.items():
        for example in members:
            other_split, other = first.setdefault(example.pixels, (split, example.image))
            if other_split != split:
                yield Problem(
                    example.image,
                    f"the same picture is in {other_split} ({other}): scores would be too good",
                )


def _relative(path: Path, root: Path) -> str:
    return path.relative_to(root).as_posix() if path.is_relative_to(root) else path.as_posix()
