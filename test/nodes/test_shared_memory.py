# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Shared memory of killed processes is given back, and nobody else's."""

from __future__ import annotations

import fcntl
import os
import time

from aerial_gnss_ros.nodes.shared_memory import remove_abandoned

OLD_S = 1000.0


def segment(folder, number, age_s=OLD_S):
    name = f"fastrtps_{number:016x}"
    for path in (folder / name, folder / f"{name}_el"):
        path.write_bytes(b"x")
        os.utime(path, (time.time() - age_s,) * 2)
    return folder / f"{name}_el"


def test_what_nobody_locks_goes_and_the_rest_stays(tmp_path):
    segment(tmp_path, 1)
    segment(tmp_path, 2, age_s=5.0)
    locked = segment(tmp_path, 3)
    others = [tmp_path / name for name in ("fastrtps_port7000", "fastrtps_port7000_el", "sem.x",
                                           "psm_el", "fastrtps_12_el")]  # fmt: skip
    for path in others:
        path.write_bytes(b"x")
        os.utime(path, (0.0, 0.0))
    with locked.open() as owner:
        fcntl.flock(owner, fcntl.LOCK_EX)
        assert remove_abandoned(tmp_path) == 1
        left = {path.name for path in tmp_path.iterdir()}
        assert left == {path.name for path in others} | {
            f"fastrtps_{number:016x}{end}" for number in (2, 3) for end in ("", "_el")
        }
    assert remove_abandoned(tmp_path) == 1  # its owner is gone now


def test_a_link_is_not_followed(tmp_path):
    target = tmp_path / "target"
    target.write_bytes(b"x")
    os.utime(target, (0.0, 0.0))
    (tmp_path / f"fastrtps_{4:016x}_el").symlink_to(target)
    assert remove_abandoned(tmp_path) == 0
    assert target.exists()


def test_a_system_without_the_folder_has_nothing_to_remove(tmp_path):
    assert remove_abandoned(tmp_path / "absent") == 0
