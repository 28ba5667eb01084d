# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Columns of a DJI log by their names in several exporters."""

from __future__ import annotations

from pathlib import Path

import pytest

from aerial_gnss_ros.adapters.dji_columns import has_unit, is_true, match_columns, seconds
from aerial_gnss_ros.adapters.dji_log import read_dji_log
from aerial_gnss_ros.core.values.errors import InputError


def test_a_long_unknown_header_is_reported_with_what_was_expected(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(",".join(f"column{i}" for i in range(200)) + "\n")
    with pytest.raises(InputError, match=r"found: column0, .* and 140 more; expected: OSD\.latit"):
        read_dji_log(path)


@pytest.mark.parametrize(
    ("height", "metres", "unit", "reported"),
    [
        ("OSD.height [ft]", 0.3048, "feet, converted to m", True),
        ("OSD.height [m]", 1.0, "m", True),
        ("OSD.height", 1.0, "m", False),
        ("height_above_takeoff(feet)", 0.3048, "feet, converted to m", True),
        ("altitude_above_seaLevel(meters)", 1.0, "m", True),
    ],
)
def test_a_height_is_in_the_unit_of_its_column(height, metres, unit, reported):
    header = ["LATITUDE", "longitude", height, "pitch(degrees)", "OSD.yaw [360]", "gimbal.pitch"]
    columns = match_columns(Path("log.csv"), header)
    assert (columns.metres, columns.unit, has_unit(columns)) == (metres, unit, reported)
    assert columns.name("height") == height
    assert "roll" not in columns
    assert columns.text("latitude", [" 13.2 "]) == "13.2"
    assert columns.text("yaw", [" 13.2 "]) == ""  # the row is too short


def test_the_surer_name_of_a_column_wins_wherever_it_stands():
    header = ["altitude", "latitude", "longitude", "pitch", "compass_heading", "yaw"]
    columns = match_columns(Path("log.csv"), [*header, "gimbal_pitch", "height"])
    assert (columns.name("height"), columns.name("yaw")) == ("height", "yaw")
    assert "altitude" in columns


@pytest.mark.parametrize(
    ("name", "text", "s"),
    [
        ("OSD.flyTime [s]", "12.5", 12.5),
        ("time(millisecond)", "12500", 12.5),
        ("OSD.flyTime", "12.5s", 12.5),
        ("OSD.flyTime", "1m 2.5s", 62.5),
        ("OSD.flyTime", "1h 1m 2.5s", 3662.5),
        ("OSD.flyTime", "1:01:02.5", 3662.5),
        ("nothing", "12.5", 0.7),  # the eighth row at 10 Hz
    ],
)
def test_times_are_read_in_each_form(name, text, s):
    required = ["latitude", "longitude", "height", "pitch", "yaw", "gimbal_pitch"]
    columns = match_columns(Path("log.csv"), [name, *required])
    assert seconds(columns, [text], 7, 10.0) == pytest.approx(s)


@pytest.mark.parametrize("text", ["", "soon", "1m", "1:x"])
def test_a_time_that_is_none_is_refused(text):
    required = ["latitude", "longitude", "height", "pitch", "yaw", "gimbal_pitch"]
    columns = match_columns(Path("log.csv"), ["OSD.flyTime", *required])
    with pytest.raises(ValueError, match="to float"):
        seconds(columns, [text], 7, 10.0)


def test_a_video_is_recorded_where_a_field_says_so():
    assert all(map(is_true, ("True", "1", "1.0", "yes", "Recording", "Starting")))
    assert not any(map(is_true, ("", "False", "0", "no", "Stopped")))
