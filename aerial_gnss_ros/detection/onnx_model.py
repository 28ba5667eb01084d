# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Metadata of an ONNX detection model, independent of the runtime."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.letterbox import Letterbox
from aerial_gnss_ros.text.plain_text import printable
from aerial_gnss_ros.text.sentences import counted, cut, shown

_MOST_NAMES = 1_000_000  # characters
_UNREADABLE = (ValueError, TypeError, SyntaxError, RecursionError, MemoryError, OverflowError)


@dataclass(frozen=True)
class InputSize:
    """The network's input: width and height in px, or None if any multiple of 32 is accepted."""

    fixed: tuple[int, int] | None

    def letterbox(self, image: Image, longest: int) -> Letterbox:
        """Return the letterbox of `image`; `longest` applies if the size is free."""
        source = (image.shape[1], image.shape[0])
        if self.fixed is not None:
            return Letterbox.fixed(source, self.fixed)
        return Letterbox.flexible(source, longest)

    @property
    def words(self) -> str:
        """The size for the message at start."""
        return f"{self.fixed[0]}x{self.fixed[1]}" if self.fixed else "any size"


def check_file(path: Path, what: str = "the model", kind: str = "an .onnx file") -> None:
    """Refuse a path that is not a file, or an empty file.

    Args:
        path: of the file.
        what: it is for, for the error.
        kind: of file expected, for the error.

    Raises:
        ModelError: the file is missing, not a file, or empty.
    """
    if not path.exists():
        raise ModelError(f"{what} {path} does not exist; give the path of {kind}.")
    if not path.is_file():
        raise ModelError(f"{what} {path} is not a file; give the path of {kind}.")
    if path.stat().st_size == 0:
        raise ModelError(f"{what} {path} is empty; it was not copied or exported completely.")


def input_size(shape: Sequence[Any], where: str) -> InputSize:
    """Return the input's size.

    Args:
        shape: of the model's input; sizes that are not whole numbers are free.
        where: the model, for the error.

    Raises:
        ModelError: not an input for one colour image.
    """
    numbers = [side if isinstance(side, int) and side > 0 else None for side in shape]
    if len(numbers) != 4 or numbers[0] not in (None, 1) or numbers[1] not in (None, 3):
        raise ModelError(
            f"{where} takes {_shape_words(shape)}, but one colour image is "
            "[1, 3, height, width]; export the model for one image."
        )
    height, width = numbers[2], numbers[3]
    if height is not None and width is not None:
        return InputSize((width, height))
    if height is None and width is None:
        return InputSize(None)
    raise ModelError(
        f"{where} takes {_shape_words(shape)}: height and width must be both fixed or both free."
    )


def _shape_words(shape: Sequence[Any]) -> str:
    return "[" + ", ".join("?" if side is None else str(side) for side in shape) + "]"


def agreed_names(own: tuple[str, ...], given: tuple[str, ...], where: str) -> tuple[str, ...]:
    """Return the class names that the configuration gives, or else the model's own.

    Args:
        own: the model's class names.
        given: `class_names` of the configuration; empty: none.
        where: the model, for the error.

    Raises:
        ModelError: another number than configured.
    """
    if given and len(own) != len(given):
        raise ModelError(
            f"{where} knows {counted(len(own), 'class')} ({_list(own)}), but class_names has "
            f"{len(given)} ({_list(given)})."
        )
    return given or own


def _list(names: tuple[str, ...]) -> str:
    most = 20
    return ", ".join(map(cut, names[:most])) + (", …" if len(names) > most else "")


def class_names(
    metadata: Mapping[str, str], given: tuple[str, ...], where: str
) -> tuple[str, ...] | None:
    """Return the class names that the configuration or the model gives, None if neither does.

    Args:
        metadata: of the model; ultralytics writes `names` and `task` into it.
        given: `class_names` of the configuration.
        where: the model, for the error.

    Raises:
        ModelError: not a detection model, unreadable names, or another number than configured.
    """
    task = metadata.get("task", "detect")
    if task != "detect":
        raise ModelError(
            f"{where} is for the task {cut(task)}; a model for the task detect is needed."
        )
    own = _own_names(metadata.get("names", ""), where)
    return agreed_names(own, given, where) if own else given or None


def _own_names(text: str, where: str) -> tuple[str, ...] | None:
    if not text:
        return None
    if len(text) > _MOST_NAMES:  # Python's own parser runs out of memory on hostile text
        raise ModelError(
            f"{where} carries class names of {len(text)} characters, which is no list."
        )
    try:
        value = ast.literal_eval(text)
        pairs = sorted(value.items()) if isinstance(value, dict) else list(enumerate(value))
        names = tuple(printable(str(name)) for _, name in pairs)
        in_order = [int(index) for index, _ in pairs] == list(range(len(pairs)))
    except _UNREADABLE as error:
        raise ModelError(
            f"{where} carries class names that cannot be read: {shown(text)}."
        ) from error
    if not names or not in_order:
        raise ModelError(f"{where} carries class names that cannot be read: {shown(text)}.")
    return names


def names_or_numbers(names: tuple[str, ...] | None, classes: int) -> tuple[str, ...]:
    """Return the class names, `class_0` and so on for a model that carries none."""
    return names if names is not None else tuple(f"class_{i}" for i in range(classes))


def tensor(image: Image, dtype: type[np.generic]) -> NDArray[Any]:
    """Return (1, 3, height, width) red, green, blue, 0 to 1, from a blue-green-red image."""
    blob = cv2.dnn.blobFromImage(image, 1.0 / 255.0, swapRB=True)
    return np.asarray(blob, dtype=dtype)
