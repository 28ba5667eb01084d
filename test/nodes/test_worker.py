# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A thread that works on the newest of what comes."""

from __future__ import annotations

import threading
import time

from aerial_gnss_ros.nodes.worker import Worker

PATIENCE_S = 90.0


def until(condition):
    """Wait for another thread."""
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_the_newest_item_wins_and_a_stopped_worker_begins_again():
    done, begun, gate = [], threading.Event(), threading.Event()

    def work(item):
        begun.set()
        assert gate.wait(PATIENCE_S)
        done.append(item)

    worker = Worker(work)
    worker.put("before the start")
    worker.start()
    worker.put(1)
    assert begun.wait(PATIENCE_S)
    for item in (2, 3, 4):
        worker.put(item)
    assert worker.dropped == 2
    gate.set()
    until(lambda: len(done) == 2)
    worker.stop()
    worker.put(5)
    assert done == [1, 4]
    worker.start()
    worker.put(6)
    until(lambda: len(done) == 3)
    worker.stop()
    assert (done, worker.dropped, worker.failure) == ([1, 4, 6], 0, None)


def test_what_work_raises_is_kept():
    error = ValueError("no")

    def work(_item):
        raise error

    worker = Worker(work)
    worker.start()
    worker.put(1)
    until(lambda: worker.failure is not None)
    worker.stop()
    assert worker.failure is error
