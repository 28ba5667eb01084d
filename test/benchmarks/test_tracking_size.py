# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Numbers that were chosen count; what follows from them, words and types do not."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from tracking_size import ROOMS, chosen, files_of, size

SOURCE = '''
import math
LIMIT = 3.0
LOW, HIGH = -1.0, math.radians(2.0)
TWICE: float = 2.0
DOUBLE = 2 * LIMIT
NAMES = ("a", "b")
KINDS = {"a": 1}
T = TypeVar("T")
lower = 4.0

class GateTuning:
    """Words."""
    sigmas: float = 3.0
    least: int = key(3, "boxes")

class Other:
    field: float = 1.0
'''


def test_chosen_numbers():
    found = dict(chosen(SOURCE))
    assert list(found) == ["LIMIT", "LOW", "HIGH", "TWICE", "GateTuning.sigmas", "GateTuning.least"]
    assert found["HIGH"] == "math.radians(2.0)"


def test_a_folder_takes_the_place_of_the_list(tmp_path):
    (tmp_path / "tracks.py").write_text("A = 1\n")
    assert [path.name for path in files_of(tmp_path, "tracker")] == ["tracks.py"]
    (tmp_path / "tracker" / "inner").mkdir(parents=True)
    (tmp_path / "tracker" / "inner" / "life.py").write_text("B = 1\nC = 2\n")
    found = size(files_of(tmp_path, "tracker"))
    assert (found.files, found.lines) == (1, 2)
    assert found.numbers == (("life.py", "B", "1"), ("life.py", "C", "2"))


def test_every_room_is_there(repository):
    core = repository / "aerial_gnss_ros" / "core"
    assert all(size(files_of(core, room)).lines for room in ROOMS)
