# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Processes that are started again, and when they are not; without ROS."""

from __future__ import annotations

import os
import signal
import sys
import time

import pytest

START = """
import sys
from aerial_gnss_ros.nodes import supervisor
pauses = supervisor.Pauses(0.1, 0.4, {steady})
commands = {commands!r}
say = lambda sentence: print(sentence, flush=True)
sys.exit(supervisor.supervise(commands, say, pauses))
"""
LIVES = "import os, time; os.write(1, b'{name} %d\\n' % os.getpid()); time.sleep(600)"


def supervised(start, steady=60.0, **scripts):
    commands = {name: [sys.executable, "-u", "-c", text] for name, text in scripts.items()}
    return start("-c", START.format(commands=commands, steady=steady))


def pid(program, name, seconds=90.0):
    return int(program.wait_for(rf"{name} (\d+)", seconds).group(1))


def gone(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return True
    return False


def within(true, seconds=90.0):
    deadline = time.monotonic() + seconds
    while not true() and time.monotonic() < deadline:
        time.sleep(0.02)
    return true()


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV, signal.SIGTERM])
def test_one_that_dies_is_started_again_and_the_other_left_alone(start, number):
    program = supervised(start, one=LIVES.format(name="one"), two=LIVES.format(name="two"))
    first, other = pid(program, "one"), pid(program, "two")
    os.kill(first, number)
    name = signal.Signals(number).name
    program.wait_for(rf"the one ended by {name} after \d+ s; it is restarted in 0.1 s\.")
    assert within(lambda: program.text.count("one ") > program.text.count("the one ended") + 1)
    assert program.text.count("two ") == 1
    assert not gone(other)
    assert program.end() == 0, program.text
    assert within(lambda: gone(other))


def test_the_pause_grows_with_every_death_and_is_short_again_after_a_long_life(start):
    soon = "import time; print('one 1', flush=True); time.sleep({})"
    program = supervised(start, one=soon.format(0.0))
    program.wait_for(r"(?s)in 0\.1 s.*in 0\.2 s.*in 0\.4 s.*in 0\.4 s")
    assert program.end() == 0
    program = supervised(start, steady=0.3, one=soon.format(0.6))
    program.wait_for(r"(?s)(in 0\.1 s.*){3}")
    assert program.end() == 0
    assert "in 0.2 s" not in program.text


def test_wrong_input_ends_all_with_status_2(start):
    program = supervised(start, one="raise SystemExit(2)", two=LIVES.format(name="two"))
    assert program.process.wait(timeout=90.0) == 2
    assert "restarted" not in program.text
    found = [line.split() for line in program.lines if line.startswith("two ")]
    assert all(within(lambda number=int(words[1]): gone(number)) for words in found)


def test_what_was_right_for_a_while_does_not_end_the_other(start, tmp_path):
    """Such as a model's file that is gone when the detector is started again in flight."""
    once = tmp_path / "once"
    script = (
        f"import pathlib, time; p = pathlib.Path({str(once)!r})\n"
        "if p.exists(): raise SystemExit(2)\n"
        "p.touch(); time.sleep(0.5); raise SystemExit(1)"
    )
    program = supervised(start, steady=0.3, one=script, two=LIVES.format(name="two"))
    program.wait_for("the one ended with status 1")
    program.wait_for("the one ended with status 2")
    assert program.process.poll() is None
    assert program.end() == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_all_with_status_0(start, number):
    program = supervised(start, one=LIVES.format(name="one"))
    child = pid(program, "one")
    assert program.end(number) == 0
    assert "restarted" not in program.text
    assert gone(child)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux notifies children")
def test_none_is_left_behind_when_the_supervisor_itself_is_killed(start):
    program = supervised(start, one=LIVES.format(name="one"))
    child = pid(program, "one")
    program.end(signal.SIGKILL)
    assert within(lambda: gone(child))
