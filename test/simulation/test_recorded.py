# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A recorded flight is flown as logged."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.adapters.dji_log import read_dji_log
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.simulation.recorded import RecordedFlight, water_seconds
from aerial_gnss_ros.simulation.sensors import geodetic

HEADER = "latitude,longitude,height [m],pitch,yaw,GIMBAL.pitch\n"


@pytest.fixture
def log(tmp_path):
    """Ten seconds north at 1.1 m/s, turning from north to east; the gimbal looks up from 6 s on."""
    rows = [
        f"{13 + i * 1e-6},-59,{10 + 0.1 * i},5,{0.9 * i},{-40 if i < 60 else 10}"
        for i in range(101)
    ]
    path = tmp_path / "log.csv"
    path.write_text(HEADER + "\n".join(rows) + "\n")
    return read_dji_log(path)


def test_at_a_row_it_is_the_row_and_between_rows_the_mean(log):
    flight = RecordedFlight(log, start_s=2.0, duration_s=5.0)
    motion = flight.sample([0.0, 1.0, 1.05])
    latitude, longitude, _ = geodetic(flight.origin, motion.antenna)
    # A tangent plane's latitude: a centimetre at most from the log's over this short flight.
    np.testing.assert_allclose(
        np.degrees(latitude), 13.0 + 1e-6 * np.array([20, 30, 30.5]), atol=1e-9
    )
    np.testing.assert_allclose(np.degrees(longitude), -59.0, atol=1e-9)
    np.testing.assert_allclose(motion.antenna[:, 2], [12.0, 13.0, 13.05])
    np.testing.assert_allclose(
        motion.enu_from_camera[1], matrix_from_quaternion(log.gimbal[30]), atol=1e-12
    )
    heading = math.degrees(math.atan2(*motion.enu_from_flu[2, :2, 0]))
    assert heading == pytest.approx(0.9 * 30.5)


def test_before_and_after_the_log_it_stands_still(log):
    motion = RecordedFlight(log, 0.0, 10.0).sample([-1.0, 0.0, 10.0, 11.0])
    np.testing.assert_array_equal(motion.camera[0], motion.camera[1])
    np.testing.assert_array_equal(motion.camera[2], motion.camera[3])


def test_pieces_that_look_at_water_are_found(log):
    starts = water_seconds(log, 2.0)
    assert starts[0] == 0.0
    assert starts[-1] == pytest.approx(3.9)
    assert len(water_seconds(log, 7.0)) == 0


@pytest.mark.parametrize(
    ("start", "duration", "words"),
    [
        (0.0, 0.0, "longer than 0 s, not 0 s"),
        (11.0, 1.0, "has no row at 11 s"),
        (8.0, 5.0, r"ends at 10.0 s, before 8 \+ 5 s"),
    ],
)
def test_a_piece_outside_the_log_is_refused(log, start, duration, words):
    with pytest.raises(InputError, match=words):
        RecordedFlight(log, start, duration)


def test_a_piece_with_missing_rows_is_refused(tmp_path):
    good = "13,-59,10,0,0,-40\n"
    path = tmp_path / "log.csv"
    path.write_text(HEADER + good * 20 + "13,-59,-1,0,0,-40\n" * 30 + good * 20)
    log = read_dji_log(path)
    with pytest.raises(InputError, match=r"no usable rows for 3\.1 s after 1\.9 s"):
        RecordedFlight(log, 1.0, 5.0)
    assert RecordedFlight(log, 5.0, 1.0).duration_s == 1.0
