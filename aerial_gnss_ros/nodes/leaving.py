# SPDX-License-Identifier: Apache-2.0
"""Ends a process with status 0 on SIGINT and SIGTERM, also while it is still importing."""

from __future__ import annotations

import signal
from types import FrameType
from typing import NoReturn

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Leave(SystemExit):
    """A signal asked the process to end; it does so with status 0."""

    def __init__(self) -> None:
        super().__init__(0)


_came: list[int] = []


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
    """Return whether a signal came; its `Leave` may have been lost in a call of compiled code."""
    return bool(_came)


def _leave(number: int, _frame: FrameType | None) -> NoReturn:
    _came.append(number)
    raise Leave
