# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Status of an input: counts of messages, and its state in one word."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class InputState(str, Enum):
    """State of an input, in one word."""

    UNUSED = "unused"
    CONSTANT = "constant"
    WAITING = "waiting"
    OK = "ok"
    STALE = "stale"
    BAD = "bad"

    def __str__(self) -> str:
        return self.value


@dataclass(frozen=True)
class InputStatus:
    """Status of one input.

    Attributes:
        name: fix, attitude, gimbal, height, water_level, camera_info or detections.
        state: unused and constant need no messages; waiting: none arrived yet; stale: the newest is
            older than the newest image by more than `max_wait`; bad: the last one was unusable.
        count: messages.
        bad: number of unusable messages.
        last_stamp_ns: newest stamp, ns; None before the first.
        trouble: why the last one was unusable, in words; empty if it was usable.
        unordered: messages no newer than an earlier one: late, or with the same stamp.
    """

    name: str
    state: InputState
    count: int = 0
    bad: int = 0
    last_stamp_ns: int | None = None
    trouble: str = ""
    unordered: int = 0


@dataclass
class MessageCounter:
    """Counts the messages of one input.

    `good_ns` is the last usable stamp, or the first one; `refused`: even the last message's stamp
    is unusable.
    """

    count: int = 0
    bad: int = 0
    unordered: int = 0
    trouble: str = ""
    last_stamp_ns: int | None = None
    good_ns: int | None = None
    refused: bool = False

    def add(self, stamp_ns: int, trouble: str = "") -> None:
        """Count a message; `trouble` says why it is unusable."""
        self.count += 1
        self.bad += bool(trouble)
        self.trouble, self.refused = trouble, False
        if not trouble or self.good_ns is None:
            self.good_ns = stamp_ns
        if self.last_stamp_ns is None or stamp_ns > self.last_stamp_ns:
            self.last_stamp_ns = stamp_ns
        else:
            self.unordered += 1

    def refuse(self, trouble: str) -> None:
        """Count a message that could not be read, or has a wrong stamp; `trouble` says why."""
        self.count += 1
        self.bad += 1
        self.trouble, self.refused = trouble, True

    def undo_refusal(self) -> None:
        """Take back a message that was refused: it is of use after all."""
        self.count -= 1
        self.bad -= 1
        self.trouble, self.refused = "", False

    def reset_stamps(self) -> None:
        """Clear the stamps after a reset of time."""
        self.last_stamp_ns = self.good_ns = None

    @property
    def bad_s(self) -> float:
        """Time for which messages have been unusable, s."""
        if not self.trouble or self.last_stamp_ns is None or self.good_ns is None:
            return 0.0
        return (self.last_stamp_ns - self.good_ns) * 1e-9

    def status(self, name: str, newest_ns: int | None, patience_ns: int) -> InputStatus:
        """Return the input's status; it is stale if too far behind the newest image."""
        state = InputState.OK
        if self.refused:
            state = InputState.BAD
        elif self.last_stamp_ns is None:
            state = InputState.WAITING
        elif newest_ns is not None and newest_ns - self.last_stamp_ns > patience_ns:
            state = InputState.STALE
        elif self.trouble:
            state = InputState.BAD
        stamp_ns, trouble = self.last_stamp_ns, self.trouble
        return InputStatus(name, state, self.count, self.bad, stamp_ns, trouble, self.unordered)
