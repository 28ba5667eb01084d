# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Faults of processes: what they do to a process, and the table of what became of them."""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("rclpy")
sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import process_faults
from process_faults import KILLED, Live, Outcome, disk_full, slow, stopped, table


@pytest.fixture
def sleeper():
    """Return a process that sleeps."""
    with subprocess.Popen(["sleep", "600"]) as process:
        yield process
        process.kill()


def during(monkeypatch, process, fault, look):
    """Put a fault in for no time; return what `look` sees at each wait, and afterwards."""
    monkeypatch.setattr(
        process_faults, "by_name", lambda _pid: dict.fromkeys(process_faults.NODES, process.pid)
    )
    seen = []
    live = Live(process, process, lambda _seconds: seen.append(look(process.pid)), Path("unused"))
    fault(live)
    return seen, look(process.pid)


def state(expected):
    """Return a function that returns a process's state: T is stopped, S sleeps.

    It waits for the next of those expected, as a signal takes a moment; not for ever.
    """
    expected = iter(expected)

    def look(pid):
        wanted, end = next(expected), time.monotonic() + 60.0
        while (found := _state(pid)) != wanted and time.monotonic() < end:
            time.sleep(0.001)
        return found

    return look


def _state(pid):
    return Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()[0]


def test_a_node_that_stands_goes_on_afterwards(monkeypatch, sleeper):
    seen, after = during(monkeypatch, sleeper, stopped("estimator"), state("TS"))
    assert (seen, after) == (["T"], "S")


def test_a_slow_detector_stands_and_runs_in_turn(monkeypatch, sleeper):
    seen, after = during(monkeypatch, sleeper, slow, state("TS" * 25 + "S"))
    assert (seen, after) == (["T", "S"] * 25, "S")


def test_a_full_disk_has_room_again_afterwards(monkeypatch, sleeper):
    def limit(pid):
        return resource.prlimit(pid, resource.RLIMIT_FSIZE)[0]

    before = limit(sleeper.pid)
    seen, after = during(monkeypatch, sleeper, disk_full, limit)
    assert (seen, after) == ([0], before)
    assert before != 0


def test_the_table_says_what_became_of_each_fault():
    killed = Outcome("both killed", False, 3.51, 4.38, 0.26, 3, 3, 0, 0, 1500)
    lost = Outcome("clock steps back", True, 0.82, 0.0, float("inf"), 0, 3, 3, 2, 900)
    rows = [line.split(" | ") for line in table([killed, lost]).splitlines()[2:]]
    assert rows[0][1:] == ["no", "3.5", "4.4", "0.3", "3 of 3", "0", "0 of 1500 |"]
    assert rows[1][1:] == ["YES", "0.8", "–", "never", "0 of 3", "3", "2 of 900 |"]


def test_only_faults_that_kill_expect_new_processes():
    assert set(KILLED) == {name for name in process_faults.FAULTS if "killed" in name}
