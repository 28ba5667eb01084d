# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A thread that processes the newest item."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from aerial_gnss_ros.nodes.newest import Newest

T = TypeVar("T")


class WorkEndedError(Exception):
    """The worker thread has ended: processing cannot continue."""


class Worker(Generic[T]):
    """Processes items in its own thread from `start` to `stop`; only the newest one waits.

    Args:
        work: processes an item; an exception ends the thread.

    Attributes:
        failure: the exception that ended the thread, or None.
    """

    def __init__(self, work: Callable[[T], None]) -> None:
        self.failure: BaseException | None = None
        self._work = work
        self._waiting: Newest[T] = Newest()
        self._thread: threading.Thread | None = None

    @property
    def dropped(self) -> int:
        """Number of items since the start that a newer one replaced."""
        return self._waiting.dropped

    def put(self, item: T) -> None:
        """Offer an item, replacing one that waits."""
        self._waiting.put(item)

    def start(self) -> None:
        """Start; a stopped worker can be started again."""
        self._waiting = Newest()
        self._thread = threading.Thread(target=self._run, name="work", daemon=True)
        self._thread.start()

    def stop(self, timeout_s: float | None = None) -> None:
        """End the thread after its current item; wait at most `timeout_s`."""
        self._waiting.close()
        if self._thread is not None:
            self._thread.join(timeout_s)
            self._thread = None

    def _run(self) -> None:
        try:
            while (item := self._waiting.pop()) is not None:
                self._work(item)
        except BaseException as error:  # noqa: BLE001 - re-raised in the starting thread
            self.failure = error
