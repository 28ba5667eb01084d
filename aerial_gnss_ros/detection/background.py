# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Background work in a thread, such as compiling a network while images are processed."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")


def begun(task: Callable[[], T], name: str) -> Future[T]:
    """Run a function in a thread, which the process joins at its end."""
    with_one = ThreadPoolExecutor(1, thread_name_prefix=name)
    made = with_one.submit(task)
    with_one.shutdown(wait=False)
    return made
