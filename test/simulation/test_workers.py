# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Work shared by processes: its order, and what ends it."""

from __future__ import annotations

import math
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Future, ProcessPoolExecutor
from pathlib import Path

import pytest

from aerial_gnss_ros.core.values.errors import OutputError
from aerial_gnss_ros.simulation.workers import shared


@pytest.mark.parametrize("processes", [1, 2])
def test_results_come_in_the_order_of_the_jobs(processes):
    assert list(shared(math.sqrt, [n * n for n in range(20)], processes, "")) == list(range(20))


def test_a_killed_process_is_reported_and_not_waited_for():
    with pytest.raises(OutputError, match="memory ran out"):
        list(shared(os._exit, [1, 1, 1], 2, "memory ran out"))


def test_a_killed_process_is_reported_also_when_the_pipe_closes_first(monkeypatch):
    """Python closes the pipe of a pool that breaks; the job being sent fails with an OSError."""
    set_exception = Future.set_exception
    closed = OSError("handle is closed")
    monkeypatch.setattr(Future, "set_exception", lambda future, _: set_exception(future, closed))
    with pytest.raises(OutputError, match="memory ran out"):
        list(shared(os._exit, [1] * 3, 2, "memory ran out"))


def test_a_file_error_of_a_job_stays_what_it_is(tmp_path):
    with pytest.raises(FileNotFoundError):
        list(shared(os.listdir, [str(tmp_path / "none")], 2, "memory ran out"))


def test_a_pool_that_breaks_finds_no_future_cancelled(monkeypatch):
    """Its thread says of each job that the pool broke, while the caller already ends it.

    Python 3.11 raises in that thread when a job that waits has been cancelled meanwhile.
    """
    caller_ends, raised = threading.Event(), []
    shutdown, set_exception = ProcessPoolExecutor.shutdown, Future.set_exception

    def ending(pool, **options):
        caller_ends.set()
        shutdown(pool, **options)

    def telling(future, error):
        set_exception(future, error)
        assert caller_ends.wait(60.0)  # the caller hears of the first one

    monkeypatch.setattr(ProcessPoolExecutor, "shutdown", ending)
    monkeypatch.setattr(Future, "set_exception", telling)
    monkeypatch.setattr(threading, "excepthook", lambda reported: raised.append(reported.exc_value))
    with pytest.raises(OutputError, match="memory ran out"):
        list(shared(os._exit, [1] * 9, 2, "memory ran out"))
    assert raised == []


def test_what_is_at_work_when_nobody_wants_it_any_more_is_ended():
    others = set(multiprocessing.active_children())
    results = shared(time.sleep, [0, 600, 600], 2, "")
    next(results)
    results.close()  # as an exception of the caller does
    assert set(multiprocessing.active_children()) == others


@pytest.fixture
def not_ignoring():
    """What is started from a shell in the background ignores Ctrl-C, and hands that on."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("not_ignoring")
def test_ctrl_c_is_for_the_parent_alone(tmp_path):
    """A traceback of every worker helps nobody."""
    folder = Path(__file__).parents[2]
    command = [sys.executable, "-m", "aerial_gnss_ros.cli", "simulate", "--dataset"]
    process = subprocess.Popen(
        [*command, str(tmp_path / "set"), "--count", "400", "--crop", "64", "--processes", "2"],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, "PYTHONPATH": str(folder)},
    )
    assert process.stderr is not None
    assert "rendering" in process.stderr.readline()
    os.killpg(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=90)
    assert process.returncode == 130
    assert "Traceback" not in said
    assert said.endswith("interrupted; nothing was written under the final name.\n")
    assert list(tmp_path.iterdir()) == []
