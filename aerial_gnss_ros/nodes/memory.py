# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the C library does with memory that is freed: keeps that of images, or gives it back."""

from __future__ import annotations

import ctypes
import sys
from typing import Any

_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD, _M_ARENA_MAX = -1, -3, -8  # <malloc.h>
_LARGEST = 32 << 20  # what glibc allows at most on 64-bit machines
_KEPT = 128 << 20
_ARENAS = 2


def keep_freed_memory() -> bool:
    """Let the C library reuse the memory of images instead of giving each back to the system.

    Each raw image passes several buffers of its size. By default each of them is asked from the
    kernel anew, which clears it page by page: 2000 page faults for an image of 1280 x 720 that only
    arrives.

    What is kept is shared by all threads that start from now on. By default most of them, such as
    those of DDS and of the network's runtime, have a part of the memory of their own: 25 MB more.

    Returns:
        False where the C library is another one than glibc: nothing is changed.
    """
    mallopt = _of_glibc("mallopt")
    if mallopt is None:
        return False
    options = ((_M_MMAP_THRESHOLD, _LARGEST), (_M_TRIM_THRESHOLD, _KEPT), (_M_ARENA_MAX, _ARENAS))
    return all(mallopt(option, value) for option, value in options)


def give_freed_memory_back() -> None:
    """Give the system all that is freed and kept, where the C library is glibc: not for each image.

    What many threads have used and freed, such as those that compile a network, is not given back
    otherwise.
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
