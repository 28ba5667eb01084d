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


def leave_on_signals() -> None:
    """Let both signals raise `Leave` in the main thread."""
    for number in SIGNALS:
        signal.signal(number, _leave)


def _leave(_number: int, _frame: FrameType | None) -> NoReturn:
    raise Leave
