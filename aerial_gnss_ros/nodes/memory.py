# SPDX-License-Identifier: Apache-2.0
"""Keeps freed memory of the size of images in the process."""

from __future__ import annotations

import ctypes
import sys

_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD = -1, -3  # <malloc.h>
_LARGEST = 32 << 20  # what glibc allows at most on 64-bit machines
_KEPT = 128 << 20


def keep_freed_memory() -> bool:
    """Let the C library reuse the memory of images instead of giving each back to the system.

    Each raw image passes several buffers of its size. By default each of them is asked from the
    kernel anew, which clears it page by page: 2000 page faults for an image of 1280 x 720 that only
    arrives.

    Returns:
        False where the C library is another one than glibc: nothing is changed.
    """
    if not sys.platform.startswith("linux"):
        return False
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, AttributeError):
        return False
    return bool(mallopt(_M_MMAP_THRESHOLD, _LARGEST)) and bool(mallopt(_M_TRIM_THRESHOLD, _KEPT))
