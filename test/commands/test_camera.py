# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss camera`: three ways to give a camera, the file it writes, and refusals."""

from __future__ import annotations

import json

import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.adapters.camera_files import read_camera_file

CALIBRATION = """\
image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [438.7, 0.0, 305.6, 0.0, 437.3, 243.7, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.361, 0.118, 0.0012, -0.0004, 0.0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [358.2, 0, 300.7, 0, 0, 406.8, 245.0, 0, 0, 0, 1, 0]
"""
ECHO = """\
header: {stamp: {sec: 1, nanosec: 2}, frame_id: camera}
height: 480
width: 640
distortion_model: plumb_bob
d: [-0.361, 0.118, 0.0012, -0.0004, 0.0]
k: [438.7, 0.0, 305.6, 0.0, 437.3, 243.7, 0.0, 0.0, 1.0]
---
"""
NUMBERS = ("--image-size", "1920x1080", "--focal-length-mm", "4.5", "--sensor-width-mm", "6.17")


def summary(capsys, *args):
    assert cli.main(["camera", *args, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("text", [CALIBRATION, ECHO])
def test_both_kinds_of_camera_info_are_read(tmp_path, capsys, text):
    path = tmp_path / "camera.yaml"
    path.write_text(text)
    found = summary(capsys, str(path), "--height", "10", "--tilt", "45")
    assert (found["width_px"], found["height_px"], found["fx_px"]) == (640, 480, 438.7)
    assert found["distortion"][0] == -0.361
    assert [row["place"] for row in found["ground"]] == ["centre", "top", "bottom"]
    assert any("stabilisation" in warning for warning in found["warnings"])
    assert any("zoom" in warning for warning in found["warnings"])


def test_what_is_written_is_read_back(tmp_path, capsys):
    path = tmp_path / "made.yaml"
    assert cli.main(["camera", *NUMBERS, "--write", str(path)]) == 0
    camera = read_camera_file(path).camera
    assert camera.K[0, 0] == pytest.approx(4.5 / 6.17 * 1920)
    assert cli.main(["camera", *NUMBERS, "--write", str(path)]) == 2
    assert "exists already" in capsys.readouterr().err


def test_a_known_drones_video_warns_of_the_crop(capsys):
    found = summary(capsys, "dji_mini_2", "--image-size", "1920x1080")
    assert any("another aspect ratio than the photo" in warning for warning in found["warnings"])
    assert cli.main(["camera", "--list"]) == 0
    assert "dji_mini_2" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ((), "no camera given"),
        (("dji_mini_two",), "not a known camera"),
        (("absent.yaml",), "absent.yaml: cannot be read: No such"),
        (("dji_mini_2", "--focal-length-mm", "4"), "given twice"),
        (NUMBERS[:4], "--sensor-width-mm too"),
        ((*NUMBERS, "--height", "-1"), "height must be above 0"),
        ((*NUMBERS, "--height", "5", "--tilt", "100"), "tilt must lie within"),
        (("dji_mini_2", "--zoom", "0"), "zoom must be above 0"),
        (("--image-size", "HD"), "such as 1920x1080"),
    ],
)
def test_wrong_input_is_one_sentence(capsys, args, words):
    assert cli.main(["camera", *args]) == 2
    sentence = capsys.readouterr().err.strip()
    assert words in sentence
    assert "\n" not in sentence


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: 1\n", "has no image_width, image_height, camera_matrix; found: a; expected"),
        (CALIBRATION.replace("438.7", "0.0").replace("437.3", "0.0"), "impossible K"),
    ],
)
def test_files_that_are_no_camera_are_refused(tmp_path, capsys, text, words):
    path = tmp_path / "camera.yaml"
    path.write_text(text)
    assert cli.main(["camera", str(path)]) == 2
    assert words in capsys.readouterr().err


def test_another_image_size_than_the_calibrations_is_refused(tmp_path, capsys):
    path = tmp_path / "camera.yaml"
    path.write_text(CALIBRATION)
    assert cli.main(["camera", str(path), "--image-size", "1280x960"]) == 2
    assert "describes images of 640x480" in capsys.readouterr().err
