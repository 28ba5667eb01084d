# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the C library does with freed memory."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import pytest

_MANY_THREADS = """
import ctypes, sys, threading
from aerial_gnss_ros.nodes.memory import keep_freed_memory
if sys.argv[1] == "kept":
    assert keep_freed_memory()
libc = ctypes.CDLL(None)
libc.malloc.restype = ctypes.c_void_p
together = threading.Barrier(8)
def take():
    libc.malloc(1000)
    together.wait()
threads = [threading.Thread(target=take) for _ in range(8)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
libc.malloc_info(0, ctypes.c_void_p.in_dll(libc, "stdout"))
libc.fflush(None)
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="the C library is not glibc")
def test_threads_share_what_is_kept():
    def arenas(how: str) -> int:
        environment = {k: v for k, v in os.environ.items() if not k.startswith("MALLOC_")}
        command = [sys.executable, "-c", _MANY_THREADS, how]
        return subprocess.run(
            command, check=True, capture_output=True, env=environment
        ).stdout.count(b"<heap nr=")

    assert arenas("kept") <= 2 < arenas("as it is")
