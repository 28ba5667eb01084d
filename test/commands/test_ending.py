# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""SIGTERM ends a command as Ctrl-C does, and only while it works."""

from __future__ import annotations

import signal
import threading

import pytest

from aerial_gnss_ros.commands.ending import ended_cleanly


def test_sigterm_is_a_keyboard_interrupt_within_the_block_alone():
    before, ended = signal.getsignal(signal.SIGTERM), []

    def work():
        with ended_cleanly():
            signal.raise_signal(signal.SIGTERM)
            ended.append("it went on")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert ended == []
    assert signal.getsignal(signal.SIGTERM) is before


def test_in_another_thread_nothing_is_changed():
    before, seen = signal.getsignal(signal.SIGTERM), []

    def work():
        with ended_cleanly():
            seen.append(signal.getsignal(signal.SIGTERM))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join(60.0)
    assert seen == [before]
