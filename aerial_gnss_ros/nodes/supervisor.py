# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Runs each node in its own process and restarts one that dies.

A crash of one, even inside the inference runtime, does not affect the other. Wrong input, which a
restart cannot fix, ends all. Independent of ROS.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from aerial_gnss_ros.nodes.executable import WRONG_INPUT
from aerial_gnss_ros.nodes.leaving import asked_to_leave, leave_on_signals, noted_only
from aerial_gnss_ros.nodes.shared_memory import remove_abandoned
from aerial_gnss_ros.nodes.transport import use_prompt_profile

_LOOK_S = 0.05
_END_S = 15.0
_PR_SET_PDEATHSIG = 1  # <linux/prctl.h>


@dataclass(frozen=True)
class Pauses:
    """Pauses before restarts of a process.

    Attributes:
        first_s: first pause, s; it doubles after each short run.
        longest_s: longest pause, s.
        steady_s: after a run of this length the input counts as right, and the pause is `first_s`
            again, s.
    """

    first_s: float = 0.5
    longest_s: float = 8.0
    steady_s: float = 20.0


@dataclass
class _Child:
    """One node's process.

    Attributes:
        name: of the node.
        command: that starts it.
        process: None while it waits to be restarted.
        began_s: when it was started, monotonic.
        due_s: when it is due to start, monotonic.
        pause_s: before the next restart.
        was_well: whether it has once run for `Pauses.steady_s`.
    """

    name: str
    command: Sequence[str]
    pause_s: float
    process: subprocess.Popen[bytes] | None = None
    began_s: float = 0.0
    due_s: float = 0.0
    was_well: bool = False


def supervise(
    commands: Mapping[str, Sequence[str]],
    say: Callable[[str], None],
    pauses: Pauses | None = None,
) -> int:
    """Run a process for each node until SIGINT or SIGTERM, restarting those that end.

    Args:
        commands: by node name; they must exit with status 2 on wrong input.
        say: called with each sentence for the log.
        pauses: before restarts.

    Returns:
        0 after a signal, 2 after wrong input.
    """
    leave_on_signals()
    pauses = pauses or Pauses()
    children = [_Child(name, command, pauses.first_s) for name, command in commands.items()]
    with noted_only():
        try:
            while not asked_to_leave():
                for child in children:
                    if _tend(child, pauses, say) == WRONG_INPUT:
                        return WRONG_INPUT
                time.sleep(_LOOK_S)
            return 0
        finally:
            _end([child.process for child in children if child.process is not None])


def _tend(child: _Child, pauses: Pauses, say: Callable[[str], None]) -> int:
    """Start a process that is due, or check whether it ended; return 2 if it refused its input."""
    now_s = time.monotonic()
    if child.process is None:
        if now_s >= child.due_s:
            child.process = _started(child.command)
            child.began_s = now_s
        return 0
    lived_s = now_s - child.began_s
    child.was_well |= lived_s >= pauses.steady_s
    status = child.process.poll()
    if status is None:
        return 0
    if asked_to_leave():  # the terminal signals all processes
        return 0
    if status == WRONG_INPUT and not child.was_well:
        return WRONG_INPUT
    if lived_s >= pauses.steady_s:
        child.pause_s = pauses.first_s
    say(
        f"the {child.name} ended {_how(status)} after {lived_s:.0f} s; it is restarted in "
        f"{child.pause_s:g} s."
    )
    if status < 0:
        remove_abandoned()
    child.process, child.due_s = None, now_s + child.pause_s
    child.pause_s = min(2.0 * child.pause_s, pauses.longest_s)
    return 0


def _how(status: int) -> str:
    if status >= 0:
        return f"with status {status}"
    with contextlib.suppress(ValueError):
        return f"by {signal.Signals(-status).name}"
    return f"by signal {-status}"


def _started(command: Sequence[str]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(command, preexec_fn=_DIE_WITH_PARENT)  # noqa: S603, PLW1509


def _end(processes: Sequence[subprocess.Popen[bytes]]) -> None:
    """Interrupt processes, and kill those that do not end."""
    for process in processes:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
    deadline_s = time.monotonic() + _END_S
    for process in processes:
        _await_end(process, deadline_s - time.monotonic())


def _await_end(process: subprocess.Popen[bytes], seconds: float) -> None:
    try:
        process.wait(max(0.0, seconds))
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _die_with_parent() -> Callable[[], None] | None:
    """Return a function that makes a child end when this process is killed; None if unsupported."""
    if not sys.platform.startswith("linux"):
        return None
    prctl = ctypes.CDLL(None).prctl  # looked up here: a forked child should not load libraries

    def ask() -> None:
        prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)

    return ask


_DIE_WITH_PARENT = _die_with_parent()


def node_environment() -> None:
    """Let children find this package, and nothing else in the working folder; and be found soon.

    `python -m` searches the working folder first, which may hold unrelated files.
    """
    if Path(__file__).resolve().parents[2] != Path.cwd():
        os.environ["PYTHONSAFEPATH"] = "1"  # Python 3.11 and later
    use_prompt_profile()
