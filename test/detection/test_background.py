# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Work in a thread of its own, whose result or error comes back."""

from __future__ import annotations

import threading

import pytest

from aerial_gnss_ros.detection.background import begun


def test_it_goes_on_beside_the_caller_in_a_named_thread_that_ends_with_it():
    free = threading.Event()

    def work():
        assert free.wait(60.0)
        return threading.current_thread()

    made = begun(work, "compile")
    assert not made.done()
    free.set()
    thread = made.result(60.0)
    thread.join(60.0)
    assert not thread.is_alive()
    assert thread.name.startswith("compile")


def test_an_error_comes_back():
    made = begun(lambda: 1 // 0, "compile")
    with pytest.raises(ZeroDivisionError):
        made.result(60.0)
