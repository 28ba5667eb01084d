# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A thread that works on the newest of what comes."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from aerial_gnss_ros.nodes.newest import Newest

T = TypeVar("T")


class WorkEndedError(Exception):
    """The thread that works has ended: nothing goes on without it."""


class Worker(Generic[T]):
    """Works in a thread of its own, from `start` to `stop`: the newest item wins.

    Args:
        work: does an item; what it raises ends the thread.

    Attributes:
        failure: what ended the thread; None as long as all is well.
    """

    def __init__(self, work: Callable[[T], None]) -> None:
        self.failure: BaseException | None = None
        self._work = work
        self._waiting: Newest[T] = Newest()
        self._thread: threading.Thread | None = None

    @property
    def dropped(self) -> int:
        """Items since the start that a newer one replaced."""
        return self._waiting.dropped

    def put(self, item: T) -> None:
        """Offer an item; one that waits is replaced."""
        self._waiting.put(item)

    def start(self) -> None:
        """Begin; a worker that has been stopped can begin again."""
        self._waiting = Newest()
        self._thread = threading.Thread(target=self._run, name="work", daemon=True)
        self._thread.start()

    def stop(self, timeout_s: float | None = None) -> None:
        """End the thread, which finishes its item first; wait for that at most `timeout_s`."""
        self._waiting.close()
        if self._thread is not None:
            self._thread.join(timeout_s)
            self._thread = None

    def _run(self) -> None:
        try:
            while (item := self._waiting.take()) is not None:
                self._work(item)
        except BaseException as error:  # noqa: BLE001 - for whoever started the thread to raise
            self.failure = error
