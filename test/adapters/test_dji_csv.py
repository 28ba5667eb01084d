# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The same flight as several exporters write it, and files that are no flight."""

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
    assert any("assumed relative to the nose" in guess for guess in log.guesses)
    east_5_left = matrix_from_quaternion(log.gimbal)[list(yaws).index(90)][:, 0]
    np.testing.assert_allclose(
        east_5_left, [np.cos(np.radians(5)), -np.sin(np.radians(5)), 0], atol=1e-12
    )
    path.write_text(header + "".join(f"13,-59,20,0,{yaw},0,{yaw}\n" for yaw in yaws))
    assert not any("nose" in guess for guess in read_dji_log(path).guesses)


@pytest.mark.parametrize(
    ("place", "asked"),
    [("0.23,-1.04", True), ("-1.57,3.14", True), ("1.6,0.1", False), ("0.2,-59", False)],
)
def test_places_that_could_be_radians_are_asked_about(tmp_path, place, asked):
    header = "OSD.latitude,OSD.longitude,OSD.height [m],OSD.pitch,OSD.yaw,GIMBAL.pitch\n"
    path = tmp_path / "log.csv"
    path.write_text(header + f"{place},20,0,0,-80\n{place},20,0,90,-90\n")
    assert any("Guinea" in guess for guess in read_dji_log(path).guesses) is asked


@pytest.mark.parametrize(
    ("yaw", "pitch", "asked"),
    [("4.1068", "-1.5708", True), ("-3.1416", "0", True), ("6.3", "0", False), ("0", "-90", False)],
)
def test_angles_that_could_be_radians_are_asked_about(tmp_path, yaw, pitch, asked):
    header = "OSD.latitude,OSD.longitude,OSD.height [m],OSD.pitch,OSD.yaw,GIMBAL.pitch\n"
    path = tmp_path / "log.csv"
    path.write_text(header + f"13,-59,20,0,0,0\n13,-59,20,0,{yaw},{pitch}\n")
    found = [guess for guess in read_dji_log(path).guesses if "could be radians" in guess]
    assert len(found) == asked
    assert not asked or f"none is beyond {abs(float(yaw)):.4g}," in found[0]


@pytest.mark.parametrize("separator", [";", "\t"])
@pytest.mark.parametrize("named", [True, False])
def test_another_separator_is_read(tmp_path, separator, named):
    text = VIEWER.replace(",", separator)
    path = tmp_path / "log.csv"
    path.write_text(text if named else text.partition("\n")[2])
    log = read_dji_log(path)
    assert len(log) == 3
    assert len(log.recordings_s) == 1


@pytest.mark.parametrize(("separator", "quote"), [(";", ""), ("\t", ""), (",", '"')])
def test_numbers_with_a_decimal_comma_are_read(tmp_path, separator, quote):
    header, *rows = VIEWER.splitlines()[1:]
    lines = [header.replace(",", separator)]
    for row in rows:
        fields = [field.replace(".", ",") for field in row.split(",")]
        lines.append(separator.join(f"{quote}{field}{quote}" for field in fields))
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines))
    log = read_dji_log(path)
    assert log.stamps_ns.tolist() == [1_000_000_000, 1_100_000_000, 1_200_000_000]
    assert np.degrees([log.latitude[0], log.longitude[0]]) == pytest.approx([13.2, -59.6])
    assert log.height[0] == pytest.approx(30.48)
    assert "numbers: with a decimal comma" in log.statements


def test_a_point_beside_decimal_commas_makes_no_number(tmp_path):
    header = "OSD.latitude;OSD.longitude;OSD.height [m];OSD.pitch;OSD.yaw;GIMBAL.pitch\n"
    path = tmp_path / "log.csv"
    path.write_text(header + "13,2;-59,6;999,5;0;0;-90\n" * 2 + "13,2;-59,6;1.000;0;0;-90\n")
    log = read_dji_log(path)
    assert log.height.tolist() == [999.5, 999.5]
    assert [(row.line, row.reason) for row in log.refused] == [
        (4, "a value is missing or not a number")
    ]


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
