# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The file that keeps a person's marks: a line each, appended at once, so that none is lost."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.core.values.errors import InputError, OutputError
from aerial_gnss_ros.teaching.carry import Mark
from aerial_gnss_ros.text.sentences import shown

FILE = "marks.jsonl"
FORMAT = 1


@dataclass(frozen=True)
class Statement:
    """A mark and the class of its robot.

    Attributes:
        mark: robot, frame, box.
        class_name: of the robot.
    """

    mark: Mark
    class_name: str

    def as_dict(self) -> dict[str, Any]:
        """Return the statement for JSON."""
        box = self.mark.box
        return {
            "robot": self.mark.robot,
            "class": self.class_name,
            "frame": self.mark.frame,
            "box": None if box is None else [round(float(value), 2) for value in box],
        }


class Project:
    """The marks of one recording.

    Args:
        folder: of the project; it exists.
        recording: name of the recording.
        count: number of its frames.

    Raises:
        InputError: the file is of another recording or damaged.
    """

    def __init__(self, folder: Path, recording: str, count: int) -> None:
        self._path = folder / FILE
        self._count = count
        self._statements: list[Statement] = []
        if self._path.is_file():
            self._load(recording)
        else:
            self._append({"format": FORMAT, "recording": recording, "frames": count})

    @property
    def statements(self) -> Sequence[Statement]:
        """All that count, in their order."""
        return tuple(self._statements)

    @property
    def marks(self) -> list[Mark]:
        """The marks alone."""
        return [one.mark for one in self._statements]

    @property
    def classes(self) -> dict[str, str]:
        """The class of each robot, in the order of their first marks."""
        known: dict[str, str] = {}
        for one in self._statements:
            known[one.mark.robot] = one.class_name
        return known

    def add(self, statement: Statement) -> bool:
        """Keep a statement; return whether it is new.

        Raises:
            InputError: its frame does not exist, or its robot has another class.
            OutputError: the disk is full.
        """
        if not 0 <= statement.mark.frame < self._count:
            raise InputError(
                f"frame {statement.mark.frame} does not exist; the recording has frames 0 to "
                f"{self._count - 1}."
            )
        known = self.classes.get(statement.mark.robot, statement.class_name)
        if known != statement.class_name:
            raise InputError(
                f"robot {shown(statement.mark.robot)} is of class {shown(known)}, not "
                f"{shown(statement.class_name)}; give another robot its own name."
            )
        entry = statement.as_dict()
        if any(one.as_dict() == entry for one in self._statements):
            return False
        self._append(entry)
        self._statements.append(statement)
        return True

    def undo(self) -> Statement | None:
        """Take back the last statement and return it; None if there is none."""
        if not self._statements:
            return None
        self._append({"undo": True})
        return self._statements.pop()

    def _append(self, entry: dict[str, Any]) -> None:
        line = json.dumps(entry, ensure_ascii=False) + "\n"
        try:
            handle = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
            try:
                os.write(handle, line.encode("utf-8"))
                os.fsync(handle)
            finally:
                os.close(handle)
        except OSError as error:
            raise OutputError(
                f"{self._path} cannot be written: {error.strerror or error}."
            ) from error

    def _load(self, recording: str) -> None:
        content = self._path.read_bytes()
        whole = content.rfind(b"\n") + 1
        if whole < len(content):  # killed while writing: that line was never confirmed
            os.truncate(self._path, whole)
        entries = []
        for number, line in enumerate(content[:whole].splitlines(), 1):
            try:
                entry = json.loads(line)
            except ValueError as error:
                raise InputError(f"{self._path}, line {number}, is damaged ({error}).") from error
            if not isinstance(entry, dict):
                raise InputError(f"{self._path}, line {number}, is damaged (not an object).")
            entries.append((number, entry))
        if not entries:
            self._append({"format": FORMAT, "recording": recording, "frames": self._count})
            return
        head = entries[0][1]
        if head.get("format") != FORMAT:
            raise InputError(f"{self._path} is not a file of marks of this version.")
        if (head.get("recording"), head.get("frames")) != (recording, self._count):
            raise InputError(
                f"{self._path} has marks of {shown(head.get('recording'))} with "
                f"{head.get('frames')} frames, not of {shown(recording)} with {self._count}; give "
                "another folder."
            )
        for number, entry in entries[1:]:
            if entry.get("undo"):
                if self._statements:
                    self._statements.pop()
                continue
            self._statements.append(self._statement(number, entry))

    def _statement(self, number: int, entry: dict[str, Any]) -> Statement:
        try:
            values = entry["box"]
            box = None if values is None else np.array(values, dtype=np.float64).reshape(4)
            mark = Mark(str(entry["robot"]), int(entry["frame"]), box)
            return Statement(mark, str(entry["class"]))
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"{self._path}, line {number}, is damaged ({error}).") from error
