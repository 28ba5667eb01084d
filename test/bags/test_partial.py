# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Results appear whole under their final name, or not at all."""

from __future__ import annotations

import subprocess
import sys

import pytest

from aerial_gnss_ros.bags.partial import partial
from aerial_gnss_ros.core.values.errors import OutputError


def test_a_full_disk_names_what_the_user_asked_for(tmp_path):
    """A bag lies in a folder that is partial itself; a limit for files stands for the disk."""
    text = """
import resource, sys
from pathlib import Path
from aerial_gnss_ros.bags.partial import partial
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
try:
    with partial(Path(sys.argv[1])) as folder:
        folder.mkdir()
        with partial(folder / "bag") as bag:
            bag.write_bytes(bytes(2000))
except Exception as error:
    print(type(error).__name__, error)
"""
    done = subprocess.run(
        [sys.executable, "-c", text, tmp_path / "out"], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"OutputError {tmp_path / 'out'} cannot be written: File too large.\n"
    assert list(tmp_path.iterdir()) == []


def test_a_result_takes_its_name_when_it_is_whole(tmp_path):
    final = tmp_path / "deep" / "out.csv"
    with partial(final) as place:
        assert place.parent.parent == final.parent  # the same disk
        place.write_text("1")
        assert not final.exists()
    assert final.read_text() == "1"
    assert list(final.parent.iterdir()) == [final]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit])
def test_an_error_leaves_nothing(tmp_path, error):
    def fail():
        with partial(tmp_path / "out") as place:
            place.mkdir()
            (place / "half").write_text("1")
            raise error

    with pytest.raises(error):
        fail()
    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_run_has_left_is_removed(tmp_path):
    left = tmp_path / ".out.partial"
    left.mkdir()
    (left / "half").write_text("1")
    with partial(tmp_path / "out") as place:
        assert list(left.iterdir()) == []
        place.mkdir()
    assert [one.name for one in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("when", ["before", "meanwhile"])
def test_nothing_is_overwritten(tmp_path, when):
    final = tmp_path / "out"

    def write():
        with partial(final) as place:
            place.write_text("new")
            final.write_text("precious")

    if when == "before":
        final.symlink_to(tmp_path / "nowhere")
    with pytest.raises(OutputError, match="out exists already; choose another name or remove it"):
        write()
    assert when == "before" or final.read_text() == "precious"
    assert [one.name for one in tmp_path.iterdir()] == ["out"]
