# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A failure becomes a value; want of memory does not."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.estimation.attempt import attempt


def raising(error):
    def work():
        raise error

    return work


def test_returns_what_work_gives_or_why_it_failed():
    error = ZeroDivisionError("of this test")
    assert attempt(lambda: 5) == 5
    assert attempt(raising(error)) is error


@pytest.mark.parametrize("error", [MemoryError, KeyboardInterrupt])
def test_what_ends_the_program_ends_it(error):
    with pytest.raises(error):
        attempt(raising(error()))
