# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""DJI flight records: columns, units, signs and refusals."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.adapters.dji_log import read_dji_log, summarise_refusals
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion
from aerial_gnss_ros.core.values.errors import InputError

HEADER = "OSD.latitude,OSD.longitude,OSD.height [ft],OSD.pitch,OSD.yaw [360],GIMBAL.pitch\n"


def write(tmp_path, text):
    path = tmp_path / "log.csv"
    path.write_text(text)
    return path


def test_a_row_becomes_si_and_this_packages_frames(tmp_path):
    log = read_dji_log(
        write(tmp_path, HEADER + "13.0,-59.0,100,10,90,-30\n13.0,-59.0,100,0,0,-90\n")
    )
    assert log.stamps_ns.tolist() == [0, 100_000_000]
    np.testing.assert_allclose(log.latitude, np.radians(13.0))
    np.testing.assert_allclose(log.height, 30.48)
    forward = matrix_from_quaternion(log.gimbal)[:, :, 0]
    # Heading 90 deg, 30 deg below the horizon: east and down. Then straight down, top is north.
    np.testing.assert_allclose(forward[0], [np.cos(np.pi / 6), 0, -0.5], atol=1e-12)
    np.testing.assert_allclose(forward[1], [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(matrix_from_quaternion(log.gimbal)[1][:, 2], [0, 1, 0], atol=1e-12)
    nose = matrix_from_quaternion(log.attitude)[0][:, 0]
    np.testing.assert_allclose(nose, [np.cos(np.radians(10)), 0, np.sin(np.radians(10))])


def test_metres_altitude_roll_and_time_columns(tmp_path):
    text = (
        "sep=,\nOSD.flyTime [s],OSD.latitude,OSD.longitude,OSD.altitude [m],OSD.roll,OSD.pitch,"
        "OSD.yaw,GIMBAL.pitch,GIMBAL.roll,GIMBAL.yaw\n"
        "5.0,13,-59,12.5,20,0,-90,0,0,90\n5.3,13,-59,12.5,0,0,-90,0,0,90\n"
    )
    log = read_dji_log(write(tmp_path, text))
    assert log.height.tolist() == [12.5, 12.5]
    assert np.diff(log.stamps_ns).tolist() == [300_000_000]
    # Heading -90 is west; the right wing (north there) goes down with positive roll.
    left = matrix_from_quaternion(log.attitude)[0][:, 1]
    np.testing.assert_allclose(
        left, [0, -np.cos(np.radians(20)), np.sin(np.radians(20))], atol=1e-9
    )
    np.testing.assert_allclose(matrix_from_quaternion(log.gimbal)[0][:, 0], [1, 0, 0], atol=1e-12)
    assert any("OSD.altitude [m]" in text and "sea level" in text for text in log.statements)


def test_bad_rows_are_refused_with_their_lines_and_keep_the_others_time(tmp_path):
    good = "13,-59,20,0,0,-60\n"
    text = HEADER + good + "13,-59,-1,0,361,-60\n13,-59,,0,0,-60\n0,0,20,0,0,-60\n13,-59\n" + good
    log = read_dji_log(write(tmp_path, text))
    assert log.stamps_ns.tolist() == [0, 500_000_000]
    assert [row.line for row in log.refused] == [3, 4, 5, 6]
    assert summarise_refusals(log.refused) == (
        "1 row: an angle out of range (line 3); "
        "2 rows: a value is missing or not a number (lines 4, 6); "
        "1 row: position 0, 0: no fix (line 5)"
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("a,b\n1,2\n", r"no column for latitude, .*found: a, b; expected: OSD\.latitude"),
        (HEADER.replace("[ft]", "[yd]") + "1,1,1,1,1,1\n", "no column for height"),
        (HEADER, "0 usable rows"),
        (HEADER + "13,-59,-5,0,0,-361\n" * 3, r"0 usable rows.*3 rows: an angle out of range"),
    ],
)
def test_a_file_that_is_no_flight_is_refused_in_words(tmp_path, text, words):
    with pytest.raises(InputError, match=words):
        read_dji_log(write(tmp_path, text))


def test_a_missing_or_binary_file_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"absent\.csv: cannot be read"):
        read_dji_log(tmp_path / "absent.csv")
    binary = tmp_path / "log.csv"
    binary.write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(InputError, match=r"log\.csv: is not text in UTF-8 \(line 1\)"):
        read_dji_log(binary)


def test_the_field_trials_logs_are_read(shared_data):
    single = read_dji_log(shared_data / "dji_single_robot.csv")
    assert len(single) == 663
    assert not single.refused
    np.testing.assert_allclose(single.height[0], 21.9 * 0.3048)
    tracking = read_dji_log(shared_data / "dji_tracking.csv")
    assert len(tracking) == 12002
    assert tracking.stamps_ns[-1] == 1_200_100_000_000
