# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Removes shared memory left behind by killed processes.

Fast DDS gives each process a segment in /dev/shm, 0.5 MB, with the profile for images 34 MB. A
killed process never releases it, and one that keeps crashing fills the memory. The owner of a
segment holds a lock on the file beside it, so a segment whose lock is free has no owner; `fastdds
shm clean` uses the same test.
"""

from __future__ import annotations

import fcntl
import os
import re
import time
from contextlib import suppress
from pathlib import Path

FOLDER = Path("/dev/shm")  # noqa: S108 - where the system has shared memory
YOUNGEST_S = 60.0
"""Segments younger than this may belong to a process that has not locked them yet."""

_LOCK = re.compile(r"(fastrtps_[0-9a-f]{16})_el")


def remove_abandoned(folder: Path = FOLDER, youngest_s: float = YOUNGEST_S) -> int:
    """Remove this user's segments whose process is gone; return how many.

    Args:
        folder: of shared memory.
        youngest_s: younger segments are kept, s.
    """
    removed = 0
    with suppress(OSError):  # no such folder
        for path in list(folder.iterdir()):
            found = _LOCK.fullmatch(path.name)
            if found is not None:
                with suppress(OSError):
                    removed += _removed(path, folder / found[1], youngest_s)
    return removed


def _removed(lock: Path, segment: Path, youngest_s: float) -> bool:
    descriptor = os.open(lock, os.O_RDONLY | os.O_NOFOLLOW)
    try:
        about = os.fstat(descriptor)
        if about.st_uid != os.getuid() or time.time() - about.st_mtime < youngest_s:
            return False
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)  # raises if it has an owner
        segment.unlink(missing_ok=True)
        lock.unlink()
        return True
    finally:
        os.close(descriptor)
