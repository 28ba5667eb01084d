# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Controls whether glibc keeps freed memory for reuse or returns it to the system."""

from __future__ import annotations

import ctypes
import sys
from typing import Any

_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD, _M_ARENA_MAX = -1, -3, -8  # <malloc.h>
_LARGEST = 32 << 20  # what glibc allows at most on 64-bit machines
_KEPT = 128 << 20
_ARENAS = 2


def keep_freed_memory() -> bool:
    """Let glibc reuse the memory of images instead of returning it to the system.

    Each raw image passes through several buffers of its size. By default each is requested from the
    kernel, which clears it page by page: 2000 page faults just to receive an image of 1280 x 720.

    Threads that start from now on share the kept memory. By default most of them, such as those of
    DDS and of the inference runtime, have their own arena: 25 MB more.

    Returns:
        False if the C library is not glibc: nothing is changed.
    """
    mallopt = _of_glibc("mallopt")
    if mallopt is None:
        return False
    options = ((_M_MMAP_THRESHOLD, _LARGEST), (_M_TRIM_THRESHOLD, _KEPT), (_M_ARENA_MAX, _ARENAS))
    return all(mallopt(option, value) for option, value in options)


def give_freed_memory_back() -> None:
    """Return all freed memory to the system if the C library is glibc; too slow for every image.

    Memory freed by many threads, such as those that compile a network, is not returned otherwise.
    """
    trim = _of_glibc("malloc_trim")
    if trim is not None:
        trim(0)


def _of_glibc(name: str) -> Any:
    if not sys.platform.startswith("linux"):
        return None
    try:
        return getattr(ctypes.CDLL(None), name)
    except (OSError, AttributeError):
        return None
