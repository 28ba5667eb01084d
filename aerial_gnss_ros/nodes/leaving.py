# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Exit with status 0 on SIGINT and SIGTERM, even while the process is still importing."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Leave(SystemExit):
    """Raised on a signal: the process exits with status 0."""

    def __init__(self) -> None:
        super().__init__(0)


_came: list[int] = []
_noted_only: list[bool] = []


def leave_on_signals() -> None:
    """Let both signals raise `Leave` in the main thread."""
    if not leaves_on(SIGNALS[0]):
        _came.clear()
    for number in SIGNALS:
        signal.signal(number, _leave)


def leaves_on(number: int) -> bool:
    """Return whether a signal raises `Leave`."""
    return signal.getsignal(number) is _leave


def asked_to_leave() -> bool:
    """Return whether a signal was received, even if its `Leave` was lost."""
    return bool(_came)


@contextmanager
def noted_only() -> Iterator[None]:
    """Keep signals from raising within the context: loops check `asked_to_leave`.

    Raised inside rclpy's C++ or during Python's shutdown, `Leave` would be lost with a traceback.
    """
    _noted_only.append(True)
    try:
        yield
    finally:
        _noted_only.pop()


def nothing_to_end(_number: int, _frame: FrameType | None) -> None:
    """Do nothing on a signal; unlike SIG_IGN, programs started from here do not inherit it."""


def _leave(number: int, _frame: FrameType | None) -> None:
    _came.append(number)
    if not _noted_only:
        raise Leave
