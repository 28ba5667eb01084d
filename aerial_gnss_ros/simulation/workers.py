# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Worker processes that end with their parent, whatever ends it."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

import cv2

from aerial_gnss_ros.core.values.errors import OutputError

Job = TypeVar("Job")
Done = TypeVar("Done")


def shared(
    work: Callable[[Job], Done], jobs: Iterable[Job], processes: int, killed: str
) -> Iterator[Done]:
    """Yield what some work makes of each job, in their order.

    Args:
        work: a function of a module, for other processes to find it.
        jobs: that can be pickled.
        processes: 1 works in this one.
        killed: the sentence of the error.

    Raises:
        OutputError: a process was killed, as the system does when memory runs out. A
            `multiprocessing.Pool` would wait for its result for ever.
    """
    if processes <= 1:
        yield from map(work, jobs)
        return
    others = set(multiprocessing.active_children())
    # Not forked: OpenCV's threads do not survive a fork.
    pool = ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"), begin)
    finished = False
    try:
        with _interrupts_held():  # the first one starts the processes
            futures = deque(pool.submit(work, job) for job in jobs)
        while futures:  # `pool.map` cancels what is left; a pool that breaks raises then
            yield futures.popleft().result()
        finished = True
    except BrokenProcessPool as error:
        raise OutputError(killed) from error
    finally:
        if not finished:  # what is at work now may take minutes, for nobody
            for child in set(multiprocessing.active_children()) - others:
                child.terminate()
        pool.shutdown(cancel_futures=True)


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Let a Ctrl-C wait, and processes that begin meanwhile never hear of it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def begin() -> None:
    """Make a worker of this process: one thread, and Ctrl-C is for the parent, which ends it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    cv2.setNumThreads(1)


def _end_with_parent() -> None:
    """A parent that is killed cannot close the pool, and its workers would wait for ever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
