# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Work in a thread of its own, such as compiling a network while images go on."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")


def begun(task: Callable[[], T], name: str) -> Future[T]:
    """Do it in a thread that ends with it, and for which the process waits at its end."""
    with_one = ThreadPoolExecutor(1, thread_name_prefix=name)
    made = with_one.submit(task)
    with_one.shutdown(wait=False)
    return made
