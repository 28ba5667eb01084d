# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Worker processes that end with their parent in any case."""

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

from aerial_gnss_ros.core.values.errors import OutputError

Job = TypeVar("Job")
Done = TypeVar("Done")


def shared(
    work: Callable[[Job], Done], jobs: Iterable[Job], processes: int, killed: str
) -> Iterator[Done]:
    """Yield the result of each job, in order.

    Args:
        work: a module-level function, importable by other processes.
        jobs: picklable arguments.
        processes: number of processes; 1: only this one.
        killed: error message for a killed process.

    Raises:
        OutputError: a process was killed, probably because memory ran out. A `multiprocessing.Pool`
            would wait for its result forever.
    """
    if processes <= 1:
        yield from map(work, jobs)
        return
    others = set(multiprocessing.active_children())
    # Not forked: OpenCV's threads do not survive a fork.
    pool = ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"), begin)
    finished = False
    try:
        with killed_process_named(pool, killed):
            with _interrupts_held():  # the first one starts the processes
                futures = deque(pool.submit(work, job) for job in jobs)
            while futures:  # `pool.map` cancels what is left; a pool that breaks raises then
                yield futures.popleft().result()
        finished = True
    finally:
        if not finished:  # running jobs may take minutes, and their results are not needed
            for child in set(multiprocessing.active_children()) - others:
                child.terminate()
        pool.shutdown(cancel_futures=True)


@contextmanager
def killed_process_named(pool: ProcessPoolExecutor, killed: str) -> Iterator[None]:
    """Raise `OutputError(killed)` where a process of the pool was killed.

    Raises:
        OutputError: a process was killed.
    """
    try:
        yield
    except BrokenProcessPool as error:
        raise OutputError(killed) from error
    except OSError as error:
        # Python closes the pipe of a pool that breaks, and the job being sent fails with that.
        if not _is_broken(pool):
            raise
        raise OutputError(killed) from error


def _is_broken(pool: ProcessPoolExecutor) -> bool:
    try:
        pool.submit(int)
    except BrokenProcessPool:
        return True
    return False


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Defer Ctrl-C; processes started meanwhile ignore it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def begin() -> None:
    """Set this process up as a worker: one thread; the parent handles Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    import cv2  # the parent may not need it

    cv2.setNumThreads(1)


def _end_with_parent() -> None:
    """A killed parent cannot close the pool, and its workers would wait forever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
