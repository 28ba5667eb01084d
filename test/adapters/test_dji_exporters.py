# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The same flight in the shapes of several exporters, and subtitles of several generations."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.adapters.dji_log import read_dji_log
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion
from aerial_gnss_ros.core.values.errors import InputError

# Heading 270 (west), nose level, camera to the south-west (225), 30 deg down, 30.48 m up.
VIEWER = """sep=,
CUSTOM.date [local],CUSTOM.updateTime [local],OSD.flyTime,OSD.flyTime [s],OSD.latitude,\
OSD.longitude,OSD.height [ft],OSD.vpsHeight [ft],OSD.altitude [ft],OSD.pitch,OSD.roll,OSD.yaw,\
OSD.yaw [360],GIMBAL.mode,GIMBAL.pitch,GIMBAL.roll,GIMBAL.yaw,GIMBAL.yaw [360],CAMERA.isPhoto,\
CAMERA.isVideo
7/10/2022,7:59:42.21 PM,0m 1.0s,1.0,13.2,-59.6,100.0,,140.0,0,0,-90,270,YawFollow,-30,0,-135,225,,
7/10/2022,7:59:42.31 PM,0m 1.1s,1.1,13.2,-59.6,100.0,,140.0,0,0,-90,270,YawFollow,-30,0,-135,225,,\
True
7/10/2022,7:59:42.41 PM,0m 1.2s,1.2,13.2,-59.6,100.0,,140.0,0,0,-90,270,YawFollow,-30,0,-135,225,,\
True
"""
PARSER = """CUSTOM.dateTime,OSD.flyTime,OSD.latitude,OSD.longitude,OSD.height,OSD.altitude,\
OSD.pitch,OSD.roll,OSD.yaw,GIMBAL.mode,GIMBAL.pitch,GIMBAL.roll,GIMBAL.yaw,CAMERA.isPhoto,CAMERA.isVideo
2022-07-10T19:59:42.210Z,1.0,13.2,-59.6,30.48,42.7,0,0,-90,YawFollow,-30,0,-135,false,false
2022-07-10T19:59:42.310Z,1.1,13.2,-59.6,30.48,42.7,0,0,-90,YawFollow,-30,0,-135,false,true
2022-07-10T19:59:42.410Z,1.2,13.2,-59.6,30.48,42.7,0,0,-90,YawFollow,-30,0,-135,false,true
"""
AIRDATA = """time(millisecond),datetime(utc),latitude,longitude,height_above_takeoff(feet),\
altitude_above_seaLevel(feet),speed(mph), compass_heading(degrees), pitch(degrees), roll(degrees),\
isPhoto,isVideo,gimbal_heading(degrees),gimbal_pitch(degrees),gimbal_roll(degrees)
1000,2022-07-10 19:59:42,13.2,-59.6,100,140,0,270,0,0,0,0,225,-30,0
1100,2022-07-10 19:59:42,13.2,-59.6,100,140,0,270,0,0,0,1,225,-30,0
1200,2022-07-10 19:59:42,13.2,-59.6,100,140,0,270,0,0,0,1,225,-30,0
"""
CLOCK_NS = 1_657_483_182_210_000_000 - 1_000_000_000


@pytest.mark.parametrize(
    ("text", "clock_ns"),
    [(VIEWER, None), (PARSER, CLOCK_NS), (AIRDATA, CLOCK_NS - 210_000_000)],
    ids=["viewer", "parser", "airdata"],
)
def test_every_exporter_gives_the_same_flight(tmp_path, text, clock_ns):
    path = tmp_path / "log.csv"
    path.write_text(text)
    log = read_dji_log(path)
    assert log.stamps_ns.tolist() == [1_000_000_000, 1_100_000_000, 1_200_000_000]
    np.testing.assert_allclose(log.height, 30.48)
    np.testing.assert_allclose(
        matrix_from_quaternion(log.attitude)[0][:, 0], [-1, 0, 0], atol=1e-12
    )
    south_west = np.cos(np.radians(30)) * np.sqrt(0.5)
    np.testing.assert_allclose(
        matrix_from_quaternion(log.gimbal)[0][:, 0], [-south_west, -south_west, -0.5], atol=1e-12
    )
    assert log.recordings_s == ((pytest.approx(1.1), pytest.approx(1.2)),)
    assert log.clock_ns == clock_ns
    assert any("unit" in guess for guess in log.guesses) is (text is PARSER)


def test_a_gimbal_yaw_that_is_from_the_nose_is_found_out(tmp_path):
    header = "OSD.latitude,OSD.longitude,OSD.height [m],OSD.pitch,OSD.yaw,GIMBAL.pitch,GIMBAL.yaw\n"
    yaws = range(-170, 180, 10)
    path = tmp_path / "log.csv"
    path.write_text(header + "".join(f"13,-59,20,0,{yaw},0,5\n" for yaw in yaws))
    log = read_dji_log(path)
    assert any("taken from the nose" in guess for guess in log.guesses)
    east_5_left = matrix_from_quaternion(log.gimbal)[list(yaws).index(90)][:, 0]
    np.testing.assert_allclose(
        east_5_left, [np.cos(np.radians(5)), -np.sin(np.radians(5)), 0], atol=1e-12
    )
    path.write_text(header + "".join(f"13,-59,20,0,{yaw},0,{yaw}\n" for yaw in yaws))
    assert not any("nose" in guess for guess in read_dji_log(path).guesses)


def test_a_long_unknown_header_is_told_with_what_was_expected(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(",".join(f"column{i}" for i in range(200)) + "\n")
    with pytest.raises(InputError, match=r"found: column0, .* and 140 more; expected: OSD\.latit"):
        read_dji_log(path)


@pytest.mark.parametrize("separator", [";", "\t"])
@pytest.mark.parametrize("named", [True, False])
def test_another_separator_is_read(tmp_path, separator, named):
    text = VIEWER.replace(",", separator)
    path = tmp_path / "log.csv"
    path.write_text(text if named else text.partition("\n")[2])
    log = read_dji_log(path)
    assert len(log) == 3
    assert len(log.recordings_s) == 1


def test_gaps_are_found(tmp_path):
    header = (
        "OSD.flyTime [s],OSD.latitude,OSD.longitude,OSD.height [m],OSD.pitch,OSD.yaw,GIMBAL.pitch\n"
    )
    path = tmp_path / "log.csv"
    times = [0.0, 0.1, 0.2, 3.7, 3.8, 9.0]
    path.write_text(header + "".join(f"{t},13,-59,20,0,0,-30\n" for t in times))
    assert read_dji_log(path).gaps_s == (
        (pytest.approx(0.2), pytest.approx(3.5)),
        (pytest.approx(3.8), pytest.approx(5.2)),
    )


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
    told = [guess for guess in guesses if guess.startswith("zoom")]
    assert len(told) == bool(words)
    assert all(words in guess for guess in told)


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


FLIGHT = np.arange(0.0, 20.0, 0.1)
TRUE_NS = 1_657_483_182_730_000_000


def airdata(path, dates):
    """An AirData table of `FLIGHT` with these dates, each in whole seconds."""
    row = "{},{},13.2,-59.6,100,140,0,270,0,0,0,0,225,-30,0\n"
    lines = [row.format(round(t * 1000), date) for t, date in zip(FLIGHT, dates, strict=True)]
    path.write_text(AIRDATA.partition("\n")[0] + "\n" + "".join(lines))
    return path


def whole_seconds(start_ns):
    seconds = (start_ns + np.round(FLIGHT * 1e9).astype(np.int64)) // 10**9
    return [f"{np.datetime64(int(s), 's')}".replace("T", " ") for s in seconds]


@pytest.mark.parametrize("phase_ns", [0, 20_000_000, 500_000_000, 990_000_000])
def test_the_start_is_found_in_a_column_of_whole_seconds(tmp_path, phase_ns):
    """One row is up to a second late; where the second changes is known to a tenth."""
    start_ns = TRUE_NS // 10**9 * 10**9 + phase_ns
    log = read_dji_log(airdata(tmp_path / "a.csv", whole_seconds(start_ns)))
    assert abs(log.clock_ns - start_ns) <= 50_000_000


def test_a_few_wrong_dates_move_nothing(tmp_path):
    dates = whole_seconds(TRUE_NS)
    dates[:30] = ["2022-07-10 07:59:42"] * 30  # before the drone knew the time
    dates[100:103] = ["", "nonsense", "9999-12-31 23:59:59"]
    log = read_dji_log(airdata(tmp_path / "a.csv", dates))
    assert abs(log.clock_ns - TRUE_NS) <= 50_000_000


@pytest.mark.parametrize("date", ["0001-01-01T00:00:00+14:00", "9999-12-31 23:59:59", "9" * 999])
def test_dates_that_no_drone_wrote_are_none(tmp_path, date):
    assert read_dji_log(airdata(tmp_path / "a.csv", [date] * len(FLIGHT))).clock_ns is None


@pytest.mark.parametrize("name", ["a.csv", "a.srt"])
@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\0" * 1000,
        b"\xef\xbb\xbf",
        "GPS(1,2,3)\n".encode("utf-16"),
        b"9" * 1_000_000,
        b'"' * 100_001,
        b"," * 1_000_000,
        bytes(range(256)) * 400,
        np.random.default_rng(3).bytes(100_000),
        VIEWER[:480].encode() + b"\0" * 100,
        VIEWER.encode().replace(b"13.2", b"nan").replace(b"1.", b"1e999"),
        VIEWER.encode().replace(b",0m 1.0s,1.0", b",," + b"9" * 400).replace(b",1.1,", b",1e8,"),
        b"1\n00:00:00,000 --> x\n" * 1000,
    ],
    ids=lambda content: str(content[:8]),
)
def test_a_file_that_is_no_log_is_one_sentence(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(InputError) as refused:
        read_dji_log(path)
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 3000


def test_a_log_with_a_byte_order_mark_and_long_lines_is_read(tmp_path):
    path = tmp_path / "a.csv"
    lines = VIEWER.splitlines()[1:]
    wide = [f"{line},{'x' * 100_000}" for line in lines]
    path.write_text("\ufeff" + "\r\n".join(wide), encoding="utf-8")
    assert len(read_dji_log(path)) == 3
