# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables of a replay as they are read back."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.bags.tables import POSITION_COLUMNS, read_positions, read_rejections
from aerial_gnss_ros.core.values.errors import InputError

HEAD = ",".join(POSITION_COLUMNS)


ROW = "17,aqua_1,aqua,13.2,-59.6,nan,4,0,4,0,0,confirmed"


@pytest.mark.parametrize(
    "change",
    [("17", "9" * 30), ("17", "9" * 5000), ("17", "1.5"), ("13.2", "inf"), ("13.2", "91"),
     ("-59.6", "nan"), ("-59.6", "181"), ("4,0,4", "nan,0,4"), ("confirmed", "conf")],
    ids=lambda change: f"{change[0]} {change[1][:8]}",
)  # fmt: skip
def test_a_number_that_is_none_is_refused(tmp_path, change):
    path = tmp_path / "positions.csv"
    path.write_text(f"{HEAD}\n{ROW}\n")
    assert len(read_positions(path)["aqua_1"]) == 1
    path.write_text(f"{HEAD}\n{ROW.replace(*change)}\n")
    with pytest.raises(InputError, match=r"positions\.csv"):
        read_positions(path)


def write(path, *rows):
    """Write a table of positions."""
    path.write_text("\n".join([HEAD, *rows]) + "\n")
    return path


def test_positions_are_tracks_by_robot(tmp_path):
    path = write(
        tmp_path / "positions.csv", ROW.replace("aqua_1", "aqua_2"), ROW,
        "18,aqua_1,aqua,13.3,-59.7,-40.5,4,0.5,9,0,0,coasting",
    )  # fmt: skip
    tracks = read_positions(path)
    assert [(name, len(track)) for name, track in tracks.items()] == [("aqua_1", 2), ("aqua_2", 1)]
    track = tracks["aqua_1"]
    assert track.stamps_ns.tolist() == [17, 18]
    assert np.degrees(track.latitude).tolist() == pytest.approx([13.2, 13.3])
    assert np.degrees(track.longitude).tolist() == pytest.approx([-59.6, -59.7])
    assert track.covariance[1].tolist() == [[4.0, 0.5], [0.5, 9.0]]
    assert track.measured.tolist() == [True, False]


def test_rejections_are_counted_by_reason(tmp_path):
    assert read_rejections(tmp_path / "rejected.csv") == {}
    path = tmp_path / "rejected.csv"
    path.write_text("stamp_ns,reason\n1,gated\n2,no_fix\n3,gated\n")
    assert read_rejections(path) == {"gated": 2, "no_fix": 1}


def test_a_missing_table_is_named(tmp_path):
    with pytest.raises(InputError, match=r"There is no .*positions\.csv; give the folder"):
        read_positions(tmp_path / "positions.csv")
