# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names for the descendants of images, which may come from several folders."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from aerial_gnss_ros.training.layout import Dataset


def unique_names(images: Sequence[Path], dataset: Dataset) -> list[str]:
    """Return a unique name for each image of a split, without ending.

    It is the image's own, with any folders below images/<split>. Images of several folders that
    have the same name get the whole path from the data set's root, or a number.
    """
    names = ["_".join(_below(image, dataset).with_suffix("").parts) for image in images]
    names = _longer(names, ["_".join(_from_root(image, dataset)) for image in images])
    return _longer(names, [f"{name}_{number}" for number, name in enumerate(names)])


def path_key(image: Path, dataset: Dataset) -> str:
    """Return a key of an image that does not depend on the data set's location or content."""
    return "/".join(_from_root(image, dataset))


def _longer(names: list[str], longer: list[str]) -> list[str]:
    count = Counter(names)
    return [long if count[name] > 1 else name for name, long in zip(names, longer, strict=True)]


def _below(image: Path, dataset: Dataset) -> Path:
    for folders in dataset.folders.values():
        for folder in folders:
            if image.is_relative_to(folder):
                return image.relative_to(folder)
    return Path(image.name)


def _from_root(image: Path, dataset: Dataset) -> tuple[str, ...]:
    inside = image.is_relative_to(dataset.root)
    path = image.relative_to(dataset.root) if inside else Path(image.name)
    return path.with_suffix("").parts
