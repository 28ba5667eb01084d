# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Paths of a data set in YOLO's layout: data.yaml, images/, labels/."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from aerial_gnss_ros.adapters.yaml_files import read_yaml
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.sentences import shown
from aerial_gnss_ros.training.labelled import ENDINGS

SPLITS = ("train", "val", "test")
NOT_LABELS = ("classes.txt",)  # label tools put it among the labels


@dataclass(frozen=True)
class Dataset:
    """A data set as its data.yaml describes it.

    Attributes:
        file: data.yaml.
        root: folder that its paths start from.
        names: of the classes, by number.
        images: of each split that it has, in order of their paths; they need not exist.
        folders: of images, of each split; empty where a split is a list of files.
    """

    file: Path
    root: Path
    names: tuple[str, ...]
    images: dict[str, tuple[Path, ...]]
    folders: dict[str, tuple[Path, ...]]


def open_dataset(path: Path) -> Dataset:
    """Return the data set of a folder with data.yaml, or of such a file.

    A split may be a folder of images, a list of them, or a text file with a path on each line.

    Raises:
        InputError: no such file, or an invalid one.
    """
    file = path / "data.yaml" if path.is_dir() else path
    if not file.is_file():
        raise InputError(
            f"{file} does not exist; give a folder in YOLO's layout (data.yaml, images/, labels/)."
        )
    content = read_yaml(file)
    if not isinstance(content, dict):
        raise InputError(f"{file} must have the keys train, val and names.")
    root = (file.parent / str(content.get("path") or ".")).resolve()
    images: dict[str, tuple[Path, ...]] = {}
    folders: dict[str, tuple[Path, ...]] = {}
    for split in SPLITS:
        if content.get(split):
            images[split], folders[split] = _images(file, root, split, content[split])
    if "train" not in images:
        raise InputError(f"{file} has no train; write for example `train: images/train`.")
    return Dataset(file, root, _names(file, content), images, folders)


def label_file(image: Path) -> Path:
    """Return the label file of an image: in labels/ beside images/, else beside the image."""
    parts = list(image.parts)
    for i in range(len(parts) - 2, -1, -1):
        if parts[i] == "images":
            parts[i] = "labels"
            break
    return Path(*parts).with_suffix(".txt")


def image_files(folder: Path) -> tuple[Path, ...]:
    """Return the images in a folder and below, in order of their paths."""
    found = (path for path in folder.rglob("*") if path.suffix.lower() in ENDINGS)
    return tuple(sorted(path for path in found if not path.name.startswith(".")))


def write_data_file(file: Path, names: Sequence[str], splits: dict[str, str]) -> None:
    """Write a data.yaml whose paths start from its own folder."""
    content = {**splits, "names": dict(enumerate(names))}
    file.write_text(yaml.safe_dump(content, sort_keys=False, allow_unicode=True), encoding="utf-8")


def _names(file: Path, content: dict[str, Any]) -> tuple[str, ...]:
    names = content.get("names")
    if isinstance(names, list):
        names = dict(enumerate(names))
    if not isinstance(names, dict) or not names:
        raise InputError(f"{file} has no names; write for example `names: {{0: aqua}}`.")
    if sorted(names, key=str) != sorted(range(len(names)), key=str):
        raise InputError(
            f"{file}: names must be numbered 0, 1, 2 and so on, not {shown(list(names))}."
        )
    if content.get("nc") not in (None, len(names)):
        raise InputError(f"{file}: nc is {shown(content['nc'])}, but there are {len(names)} names.")
    if len(set(map(str, names.values()))) != len(names):
        raise InputError(f"{file}: two classes have the same name.")
    return tuple(str(names[i]) for i in range(len(names)))


def _images(
    file: Path, root: Path, split: str, content: Any
) -> tuple[tuple[Path, ...], tuple[Path, ...]]:
    images: list[Path] = []
    folders: list[Path] = []
    for word in content if isinstance(content, list) else [content]:
        path = _path(root, str(word))
        if path.is_dir():
            folders.append(path)
            images += image_files(path)
        elif path.is_file() and path.suffix == ".txt":
            images += _listed(path)
        else:
            raise InputError(
                f"{file}: {split} is {shown(word)}, but {path} is neither a folder of images nor a "
                "text file that lists them."
            )
    return tuple(images), tuple(folders)


def _path(root: Path, word: str) -> Path:
    """Return the path of a split; Roboflow writes ../train/images for train/images."""
    path, below = root / word, root / word.removeprefix("../")
    return below if not path.exists() and below.exists() else path


def _listed(file: Path) -> list[Path]:
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError as error:
        raise InputError(f"{file} is not a list of images: it is not text.") from error
    return [(file.parent / line.strip()).resolve() for line in lines if line.strip()]
