# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss import-dji` with a video: frames, alignment, and videos of other flights."""

from __future__ import annotations

import json
import subprocess
import sys

import cv2
import numpy as np
import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.tables import read_positions
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic
from aerial_gnss_ros.detection.image_header import MAX_PIXELS
from aerial_gnss_ros.detection.images import decode

HEADER = (
    "OSD.flyTime [s],OSD.latitude,OSD.longitude,OSD.height [m],OSD.pitch,OSD.yaw,GIMBAL.pitch,"
    "CAMERA.isVideo\n"
)
SIZE, RATE = (64, 48), 10.0
HERE = np.radians([13.2, -59.6])


@pytest.fixture
def video(tmp_path):
    """Return a function that makes an mp4 whose frames are grey, brighter by 8 with each one."""

    def make(frames=30, name="video.mp4", size=SIZE):
        path = tmp_path / name
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), RATE, size)
        if not writer.isOpened():
            pytest.skip("this OpenCV has no encoder for mp4v")
        for i in range(frames):
            writer.write(np.full((size[1], size[0], 3), 8 * (i % 30), dtype=np.uint8))
        writer.release()
        return path

    return make


def log(tmp_path, recordings, length=60.0, name="log.csv"):
    """Write a flight whose isVideo is true within `recordings`."""
    rows = []
    for i in range(round(length * 10) + 1):
        t = i / 10
        on = any(a <= t <= b for a, b in recordings)
        rows.append(f"{t},13.2,-59.6,20,0,0,-90,{on if recordings else ''}\n")
    path = tmp_path / name
    path.write_text(HEADER + "".join(rows))
    return path


def run(capsys, *args):
    capsys.readouterr()
    status = cli.main(["import-dji", *map(str, args)])
    captured = capsys.readouterr()
    return status, captured.out, captured.err.strip().splitlines()


def test_frames_arrive_at_their_time_with_their_camera(tmp_path, capsys, video):
    flight = log(tmp_path, [(20.0, 23.0), (40.0, 50.0)])
    bag = tmp_path / "bag"
    status, out, err = run(capsys, flight, video(), "-o", bag, "--camera", "dji_mini_2",
                           "--every", "3", "--start", "1000", "--json")  # fmt: skip
    assert status == 0, err
    found = json.loads(out)
    assert found["video"]["begins_at_s"] == pytest.approx(20.0)
    assert "recording 1 of the log" in found["video"]["known_from"]
    assert found["messages"]["/camera/image_raw/compressed"] == 10
    with open_bag(bag) as reader:
        log_times = [recorded.log_ns for recorded in reader.messages()]
        assert log_times == sorted(log_times)
        frames = reader.messages({"/camera/image_raw/compressed"})
        images = [(recorded.log_ns, recorded.message()) for recorded in frames]
        infos = [recorded.message() for recorded in reader.messages({"/camera/camera_info"})]
    begin = 1_020_000_000_000
    assert [t - begin for t, _ in images] == [300_000_000 * i for i in range(10)]
    for i, (stamp, message) in enumerate(images):
        image = decode(message)
        assert image.shape == (48, 64, 3)
        assert abs(float(image.mean()) - 24 * i) < 6.0
        assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp
    assert {(m.width, m.height) for m in infos} == {SIZE}


def test_the_table_says_what_was_read_and_guessed(tmp_path, capsys, video):
    status, out, err = run(capsys, log(tmp_path, []), video(), "-o", tmp_path / "bag",
                           "--offset", "12.5")  # fmt: skip
    words = " ".join(out.split())
    assert status == 0, err
    assert "video begins at 12.5 s: --offset 12.5 s" in words
    assert "re-encoded as JPEG" in words
    assert "guessed" in words
    assert "camera: none in the bag" in words


def test_subtitles_go_with_their_own_video(tmp_path, capsys, video):
    srt = tmp_path / "a.srt"
    srt.write_text(
        "".join(
            f"{i + 1}\n00:00:{i:02d},000 --> 00:00:{i + 1:02d},000\n[latitude: 13.2] "
            "[longitude: -59.6] [rel_alt: 5.0 abs_alt: 1.0]\n\n"
            for i in range(4)
        )
    )
    status, out, err = run(capsys, srt, video(), "-o", tmp_path / "bag", "--json")
    assert status == 0, err
    found = json.loads(out)
    assert found["messages"]["/fix"] == 4
    assert found["messages"]["/camera/image_raw/compressed"] == 30
    assert "/gimbal" not in found["messages"]
    status, _, err = run(capsys, srt, video(300, "long.mp4"), "-o", tmp_path / "no")
    assert status == 2
    assert "log and video do not match" in err[-1]


@pytest.mark.parametrize(
    ("recordings", "extra", "words"),
    [
        ([(1.0, 20.0)], (), "different flights: the video lasts 3.0 s"),
        ([], (), "does not mark when the video was recorded"),
        ([], ("--offset", "61"), "log and video do not match"),
        ([(1.0, 4.0), (9.0, 12.0)], (), "choose with --recording"),
        ([(1.0, 4.0)], ("--recording", "2"), "the log marks 1"),
        ([(1.0, 4.0)], ("--recording", "1", "--offset", "1"), "contradict"),
        ([(1.0, 4.0)], ("--every", "0"), "--every must be 1 or more"),
        ([(1.0, 4.0)], ("--jpeg-quality", "101"), "--jpeg-quality must lie"),
        ([(1.0, 4.0)], ("--image-size", "99x99", "--camera", "dji_mini_2"), "frames are 64x48"),
    ],
)
def test_what_does_not_fit_is_refused(tmp_path, capsys, video, recordings, extra, words):
    flight, film = log(tmp_path, recordings), video()
    status, _, err = run(capsys, flight, film, "-o", tmp_path / "bag", *extra)
    assert status == 2
    assert words in err[-1]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["log.csv", "video.mp4"]


def test_a_video_that_is_cut_off_is_refused_in_one_sentence(tmp_path, video):
    flight, film = log(tmp_path, [(1.0, 4.0)]), video()
    film.write_bytes(film.read_bytes()[:-200])
    code = "import sys; from aerial_gnss_ros import cli; sys.exit(cli.main())"
    arguments = ["import-dji", flight, film, "-o", tmp_path / "bag"]
    done = subprocess.run(  # of its own: FFmpeg writes past Python, and is set up once
        [sys.executable, "-c", code, *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "copy it from the card again" in done.stderr


def test_no_video_and_a_broken_one_are_refused(tmp_path, capsys, video):
    flight = log(tmp_path, [(1.0, 4.0)])
    for film, words in ((tmp_path / "no.mp4", "does not exist"), (flight, "as a video; copy")):
        status, _, err = run(capsys, flight, film, "-o", tmp_path / "bag")
        assert status == 2
        assert any(words in line for line in err)
    status, _, err = run(capsys, flight, "-o", tmp_path / "bag", "--offset", "1")
    assert status == 2
    assert "need a video" in err[-1]
    assert not (tmp_path / "bag").exists()
    chosen = run(capsys, log(tmp_path, [(1.0, 4.0), (9.0, 12.0)], name="two.csv"), video(),
                 "-o", tmp_path / "bag", "--recording", "2", "--json")  # fmt: skip
    assert json.loads(chosen[1])["video"]["begins_at_s"] == pytest.approx(9.0)


def test_the_bag_of_log_and_video_gives_positions(tmp_path, capsys, video, detector, replay):
    """20 m up, straight down, image top to the north, 500 px: a pixel is 4 cm."""
    flight, film = log(tmp_path, [(2.0, 5.0)], length=8.0), video(size=(640, 480))
    status, _, err = run(capsys, flight, film, "-o", tmp_path / "bag", "--focal-length-mm", "5",
                         "--sensor-width-mm", "6.4")  # fmt: skip
    assert status == 0, err
    assert replay(tmp_path / "bag", tmp_path / "out") == 0
    assert detector.calls == 30
    tracks = read_positions(tmp_path / "out/positions.csv")
    found = {
        tuple(np.round(enu_from_geodetic(t.latitude[-1], t.longitude[-1], 0.0, *HERE, 0.0)[:2], 2))
        for t in tracks.values()
    }
    assert found == {(-4.0, 0.0), (2.0, 3.0)}


def test_a_picture_is_no_video(tmp_path, capsys):
    """OpenCV would decode it as a video of one frame, whatever its size."""
    path = tmp_path / "video.mp4"
    path.write_bytes(cv2.imencode(".png", np.zeros((48, 64), np.uint8))[1].tobytes())
    status, _, err = run(capsys, log(tmp_path, []), path, "-o", tmp_path / "bag")
    assert status == 2
    assert f"{path} is a PNG image, not a video" in err[0]
    assert not (tmp_path / "bag").exists()


def test_a_video_of_larger_images_than_any_camera_takes_is_refused(
    tmp_path, capsys, video, monkeypatch
):
    assert SIZE[0] * SIZE[1] < MAX_PIXELS
    monkeypatch.setattr("aerial_gnss_ros.bags.video.MAX_PIXELS", SIZE[0] * SIZE[1] - 1)
    status, _, err = run(
        capsys, log(tmp_path, []), video(), "-o", tmp_path / "bag", "--offset", "1"
    )
    assert status == 2
    assert "64 x 48 pixels is larger than 3071 pixels" in err[0]
