# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Errors of the program itself that reach a node's executor: counted, logged once, survived."""

from __future__ import annotations

import time
import traceback
from collections import deque

MOST_A_SECOND = 200
"""With more errors a second the process ends and is restarted: nothing works any more."""


class InternalErrors:
    """Counts exceptions that no callback caught.

    Attributes:
        count: since the start.
        last: type and message of the newest one; empty before the first.
    """

    def __init__(self) -> None:
        self.count = 0
        self.last = ""
        self._told: set[str] = set()
        self._times: deque[float] = deque(maxlen=MOST_A_SECOND)

    def add(self, error: Exception) -> str:
        """Count an error; return the log message: empty if the same one was logged before.

        Raises:
            Exception: the error itself, if there are too many to continue.
        """
        self.count += 1
        self.last = f"{type(error).__name__}: {error}"
        now_s = time.monotonic()
        if len(self._times) == MOST_A_SECOND and now_s - self._times[0] < 1.0:
            raise error
        self._times.append(now_s)
        frames = traceback.extract_tb(error.__traceback__)
        place = (
            f"{type(error).__name__} {frames[-1].filename}:{frames[-1].lineno}" if frames else ""
        )
        if place in self._told:
            return ""
        self._told.add(place)
        text = "".join(traceback.format_exception(error)).rstrip()
        return (
            "Internal error; the message that caused it is skipped, and the node continues. It "
            f"is logged once and counted in /diagnostics; please report it:\n{text}"
        )
