# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Gives ultralytics a part of a data set without access to the user's folders.

ultralytics writes a cache beside the labels, trusts it as long as files keep their size, and
rewrites JPEGs that do not end as it expects. So it gets a separate folder, with links to the images
(copies of those that it would change) and written labels.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from aerial_gnss_ros.training.inspection import Example
from aerial_gnss_ros.training.layout import write_data_file

_JPEG_END = b"\xff\xd9"


def write_view(folder: Path, splits: Mapping[str, Sequence[Example]], names: Sequence[str]) -> Path:
    """Create or replace `folder` and return its data.yaml.

    Args:
        folder: replaced where it exists.
        splits: images of each, train and val.
        names: of the classes.
    """
    shutil.rmtree(folder, ignore_errors=True)
    for split, examples in splits.items():
        _write(folder, split, examples)
    file = folder / "data.yaml"
    write_data_file(
        file, names, {"path": str(folder.resolve()), **{s: f"images/{s}" for s in splits}}
    )
    return file


def _write(folder: Path, split: str, examples: Iterable[Example]) -> None:
    images, labels = folder / "images" / split, folder / "labels" / split
    images.mkdir(parents=True)
    labels.mkdir(parents=True)
    for number, example in enumerate(examples):
        # Numbered, because images of several folders may have the same name.
        name = f"{number:06d}_{example.image.stem}"
        shown = images / f"{name}{example.image.suffix.lower()}"
        if _as_expected(example.image):
            shown.symlink_to(example.image.resolve())
        else:
            shutil.copyfile(example.image, shown)
        lines = [
            f"{number} {x:.7f} {y:.7f} {w:.7f} {h:.7f}\n"
            for number, (x, y, w, h) in zip(
                example.classes, np.clip(example.boxes, 0.0, 1.0), strict=True
            )
        ]
        (labels / f"{name}.txt").write_text("".join(lines), encoding="ascii")


def _as_expected(image: Path) -> bool:
    if image.suffix.lower() == ".png":
        return True
    with image.open("rb") as file:
        file.seek(-len(_JPEG_END), 2)
        return file.read() == _JPEG_END
