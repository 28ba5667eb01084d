# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads marks from a JSON file: what the page sends, written by hand or by a program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.json_text import parse_json
from aerial_gnss_ros.text.sentences import shown

KEYS = {"frame", "image", "robot", "class", "x", "y", "box", "absent"}


@dataclass(frozen=True)
class Click:
    """One mark as a person makes it.

    Attributes:
        robot, class_name: names.
        frame: index.
        point: (2,) px of a click on it; None.
        box: (4,) left, top, width, height px of a drawn box; None. Without both it is absent.
    """

    robot: str
    class_name: str
    frame: int
    point: NDArray[np.float64] | None = None
    box: NDArray[np.float64] | None = None


def read_clicks(path: Path, names: Sequence[str], default_class: str) -> list[Click]:
    """Return the clicks of a file.

    Args:
        path: JSON, `{"marks": [...]}`.
        names: of the recording's images, in the order of frames.
        default_class: of robots without one.

    Raises:
        InputError: the file is damaged or a mark is not understood.
    """
    try:
        content = parse_json(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{path} cannot be read as JSON ({error}).") from error
    marks = content.get("marks") if isinstance(content, dict) else None
    if not isinstance(marks, list) or not marks:
        raise InputError(
            f'{path} has no marks; write {{"marks": [{{"frame": 0, "x": 640, "y": 360}}]}}.'
        )
    return [click_of(mark, names, default_class, f"{path}, mark {i}") for i, mark in
            enumerate(marks, 1)]  # fmt: skip


def click_of(mark: Any, names: Sequence[str], default_class: str, where: str) -> Click:
    """Return the click that an object describes.

    Raises:
        InputError: it is not understood; begins with `where`.
    """
    if not isinstance(mark, dict) or set(mark) - KEYS:
        strange = sorted(set(mark) - KEYS) if isinstance(mark, dict) else mark
        raise InputError(f"{where}: {shown(strange)} is not known; use {', '.join(sorted(KEYS))}.")
    class_name = str(mark.get("class", default_class))
    if not class_name or "." in class_name:
        raise InputError(
            f"{where}: the class {shown(class_name)} must have a name without a dot: parameters "
            "are named classes.NAME.length_m."
        )
    robot = str(mark.get("robot", f"{class_name}_1"))
    frame = _frame(mark, names, where)
    ways = [key for key in ("x", "box", "absent") if mark.get(key) not in (None, False)]
    if len(ways) != 1:
        raise InputError(f"{where}: give either x and y, or box, or absent.")
    if ways == ["absent"]:
        return Click(robot, class_name, frame)
    if ways == ["x"]:
        return Click(robot, class_name, frame, point=_numbers([mark["x"], mark.get("y")], 2, where))
    box = _numbers(mark["box"], 4, where)
    if min(box[2:]) < 2.0:
        raise InputError(f"{where}: a box of {box[2]:g}x{box[3]:g} px is too small; draw it again.")
    return Click(robot, class_name, frame, box=box)


def _frame(mark: dict[str, Any], names: Sequence[str], where: str) -> int:
    if "image" in mark:
        if mark["image"] not in names:
            raise InputError(f"{where}: the recording has no image {shown(mark['image'])}.")
        return names.index(mark["image"])
    frame = mark.get("frame")
    if not isinstance(frame, int) or isinstance(frame, bool) or not 0 <= frame < len(names):
        raise InputError(
            f"{where}: frame is {shown(frame)}; the recording has frames 0 to {len(names) - 1}."
        )
    return frame


def _numbers(values: Any, count: int, where: str) -> NDArray[np.float64]:
    try:
        numbers = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise InputError(f"{where}: {shown(values)} must be {count} numbers, px.")
    return numbers
