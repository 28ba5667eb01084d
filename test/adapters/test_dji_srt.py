# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""DJI's subtitles of several generations."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.adapters.dji_log import read_dji_log
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion
from aerial_gnss_ros.core.values.errors import InputError

PHANTOM = "HOME(-59.6,13.2) 2017.08.05 14:11:51\nGPS(-59.6,13.2,16) BAROMETER:30.5\nISO:100"


MINI = (
    "F/2.8, SS 206.14, ISO 150, EV 0, GPS (-59.6, 13.2, 15), D 24.86m, H 30.50m, H.S 1.97m/s, "
    "V.S 0.00m/s "
)


RTK = (
    "F/6.3, SS 60, ISO 100, EV 0, RTK (-59.6, 13.2, 28), HOME (-59.6, 13.2, 1.55m), D 75.36m, "
    "H 30.50m, H.S 0.30m/s, V.S 0.00m/s, F.PRY (0.0°, 0.0°, -90.0°), G.PRY (-30.0°, 0.0°, -135.0°)"
)


AIR = (
    '<font size="36">FrameCnt : 1, DiffTime : 33ms\n2019-09-25 01:22:35,118,697\n[iso : 110] '
    "[shutter : 1/200.0] [fnum : 280] [ev : 0.7] [ct : 5064] [focal_len : 240] [latitude: 13.2] "
    "[longtitude: -59.6] [altitude: 1429.697998] </font>"
)


MINI_3 = (
    '<font size="28">SrtCnt : 1, DiffTime : 16ms\n2022-06-27 14:31:29.447\n[iso: 140] [latitude: '
    "13.2] [longitude: -59.6] [rel_alt: 30.500 abs_alt: 1586.1] [ct : 5500] </font>"
)


M30 = (
    '<font size="28">FrameCnt: 1, DiffTime: 33ms\n2023-05-01 10:00:00.033\n[focal_len: 24.00] '
    "[dzoom_ratio: 1.00], [latitude: 13.2] [longitude: -59.6] [rel_alt: 30.500 abs_alt: 70.1] "
    "[drone_yaw: -90.0 drone_pitch: 0.0 drone_roll: 0.0] [gb_yaw: -135.0 gb_pitch: -30.0 gb_roll: "
    "0.0] </font>"
)


def subtitles(path, *texts):
    path.write_text(
        "".join(
            f"{i + 1}\n00:01:{i:02d},500 --> 00:01:{i + 1:02d},500\n{text}\n\n"
            for i, text in enumerate(texts)
        ),
        encoding="utf-8",
    )
    return path


@pytest.mark.parametrize(
    ("text", "height", "gimbal"),
    [(PHANTOM, True, False), (MINI, True, False), (RTK, True, True), (AIR, False, False),
     (MINI_3, True, False), (M30, True, True)],
    ids=["phantom", "mini", "rtk", "air", "mini 3", "m30"],
)  # fmt: skip
def test_subtitles_of_every_generation_are_read(tmp_path, text, height, gimbal):
    log = read_dji_log(subtitles(tmp_path / "a.SRT", text, text, text))
    assert log.of_video
    assert log.stamps_ns.tolist() == [60_500_000_000, 61_500_000_000, 62_500_000_000]
    np.testing.assert_allclose(np.degrees(log.latitude), 13.2)
    np.testing.assert_allclose(np.degrees(log.longitude), -59.6)
    assert log.height.tolist() == ([30.5] * 3 if height else [])
    if gimbal:
        south_west = np.cos(np.radians(30)) * np.sqrt(0.5)
        np.testing.assert_allclose(
            matrix_from_quaternion(log.gimbal)[0][:, 0],
            [-south_west, -south_west, -0.5],
            atol=1e-12,
        )
        np.testing.assert_allclose(
            matrix_from_quaternion(log.attitude)[0][:, 0], [-1, 0, 0], atol=1e-12
        )
    else:
        assert len(log.gimbal) == len(log.gimbals()) == len(log.attitude) == 0
        assert any("gimbal: not recorded" in guess for guess in log.guesses)


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        ("dzoom_ratio: 1.00", "dzoom_ratio: 2.00", "dzoom_ratio is 1 to 2"),
        ("dzoom_ratio: 20000, delta:0", "dzoom_ratio: 20000, delta:0", "dzoom_ratio is 2"),
        ("focal_len: 24.00", "focal_len: 48.00", "focal_len is 24 to 48"),
        ("dzoom_ratio: 10000, delta:0", "dzoom_ratio: 10000, delta:0", ""),
        ("focal_len: 24.00", "focal_len: 24.00", ""),
    ],
)
def test_a_zoom_that_subtitles_tell_is_named(tmp_path, first, second, words):
    texts = [f"[{zoom}] [latitude: 13.2] [longitude: -59.6]" for zoom in (first, second)]
    guesses = read_dji_log(subtitles(tmp_path / "a.srt", *texts)).guesses
    reported = [guess for guess in guesses if guess.startswith("zoom")]
    assert len(reported) == bool(words)
    assert all(words in guess for guess in reported)


def test_gps_with_latitude_first_is_recognised_where_it_must_be(tmp_path):
    text = MINI.replace("(-59.6, 13.2", "(13.2, -159.6")
    log = read_dji_log(subtitles(tmp_path / "a.srt", text, text))
    np.testing.assert_allclose(np.degrees(log.longitude), -159.6)


def test_subtitles_without_telemetry_are_refused_with_what_they_say(tmp_path):
    with pytest.raises(InputError, match="«Once upon a time»; expected: GPS"):
        read_dji_log(subtitles(tmp_path / "a.srt", "<i>Once upon a time</i>", "the end"))
    (tmp_path / "b.srt").write_text("no times\n")
    with pytest.raises(InputError, match="holds no subtitles"):
        read_dji_log(tmp_path / "b.srt")
    log = read_dji_log(subtitles(tmp_path / "c.srt", MINI_3, "nothing", MINI_3))
    assert [(row.line, row.reason) for row in log.refused] == [(8, "no position")]


def test_subtitles_of_a_flight_below_the_take_off_point_keep_their_heights(tmp_path):
    text = MINI.replace("H 30.50m", "H -1.50m")
    log = read_dji_log(subtitles(tmp_path / "a.srt", text, text, MINI.replace("H 30.50m, ", "")))
    np.testing.assert_array_equal(log.height, [-1.5, -1.5, np.nan])
    assert [height.value for height in log.heights()] == [-1.5, -1.5]
    assert any("down to -1.5 m, which is below the take-off" in guess for guess in log.guesses)
    assert any("1 subtitle of 3 without one" in guess for guess in log.guesses)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (("00:01:01,500 -->", "9" * 400 + ":01:01,500 -->"), "time out of range"),
        (("00:01:01,500 -->", "9" * 5000 + ":01:01,500 -->"), "time out of range"),
        (("13.2] [longitude", "9" * 400 + "] [longitude"), "a value is missing or not a number"),
        (("13.2] [longitude", "90.1] [longitude"), "latitude or longitude out of range"),
        (("rel_alt: 30.500", "rel_alt: 10001"), "height out of range"),
        (("rel_alt: 30.500", "rel_alt: -" + "9" * 400), "height out of range"),
        (("gb_pitch: -30.0", "gb_pitch: -3000.0"), "an angle out of range"),
        (("drone_roll: 0.0", "drone_roll: " + "9" * 400), "an angle out of range"),
    ],
    ids=lambda value: value if isinstance(value, str) else value[0][:9],
)
def test_a_subtitle_with_a_number_out_of_range_is_refused(tmp_path, change, reason):
    path = subtitles(tmp_path / "a.srt", M30, M30, M30)
    head, block, tail = path.read_text(encoding="utf-8").partition("2\n00:01:01,500")
    second, third, rest = tail.partition("3\n00:01:02")
    spoilt = (block + second).replace(*change)
    assert spoilt != block + second
    path.write_text(head + spoilt + third + rest, encoding="utf-8")
    log = read_dji_log(path)
    assert log.stamps_ns.tolist() == [60_500_000_000, 62_500_000_000]
    assert [row.reason for row in log.refused] == [reason]


def test_megabytes_of_blanks_in_a_subtitle_take_no_time(tmp_path):
    blanks = "latitude" + " " * 2_000_000 + "rel_alt" + "\t" * 2_000_000 + "\nH" + " " * 2_000_000
    log = read_dji_log(subtitles(tmp_path / "a.srt", MINI_3, blanks, MINI_3))
    assert [row.reason for row in log.refused] == ["no position"]
