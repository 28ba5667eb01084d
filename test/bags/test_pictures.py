# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pictures of files, folders, videos and bags, each by its name and stamp."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.bags.pictures import open_pictures
from aerial_gnss_ros.bags.writer import SENSOR, BagWriter
from aerial_gnss_ros.core.values.errors import InputError

IMAGE = "sensor_msgs/msg/Image"


def grey(level, size=(64, 48)):
    return np.full((size[1], size[0], 3), level, dtype=np.uint8)


def levels(source):
    return [round(float(picture.read().mean())) for picture in source.pictures()]


def make_bag(path, topics=("camera/image_raw",), count=2):
    with BagWriter(path) as bag:
        for i in range(count):
            for topic in topics:
                stamp = 1_000_000_000 * (i + 1)
                message = {
                    "header": header_fields(stamp, "camera"), "width": 64, "height": 48,
                    "encoding": "mono8", "step": 64, "data": np.full(64 * 48, 9 * i, np.uint8),
                }  # fmt: skip
                bag.write(topic, IMAGE, stamp, message, SENSOR)
    return path


def test_a_folder_by_name_and_a_file_alone(tmp_path):
    for name, level in (("b.png", 20), ("a.PNG", 10), ("c.bmp", 30)):
        cv2.imwrite(str(tmp_path / name), grey(level))
    (tmp_path / "notes.txt").write_text("no picture")
    source = open_pictures(tmp_path)
    assert [picture.name for picture in source.pictures()] == ["a.PNG", "b.png", "c.bmp"]
    assert (source.count, source.rate_hz, levels(source)) == (3, 0.0, [10, 20, 30])
    alone = open_pictures(tmp_path / "b.png")
    assert [(one.name, one.stamp_ns) for one in alone.pictures()] == [("b.png", None)]


def test_a_videos_frames_have_its_times(tmp_path):
    path = tmp_path / "dive.mp4"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 4.0, (64, 48))
    if not writer.isOpened():
        pytest.skip("this OpenCV has no encoder for mp4v")
    for i in range(3):
        writer.write(grey(40 * i))
    writer.release()
    source = open_pictures(path)
    found = [(one.name, one.stamp_ns) for one in source.pictures()]
    assert found == [(f"dive_{i:06d}.jpg", i * 250_000_000) for i in range(3)]
    assert (source.count, source.rate_hz) == (3, 4.0)
    assert levels(source) == pytest.approx([0, 40, 80], abs=6)


def test_a_bags_images_have_its_stamps(tmp_path):
    source = open_pictures(make_bag(tmp_path / "bag"))
    assert [one.stamp_ns for one in source.pictures()] == [1_000_000_000, 2_000_000_000]
    assert (source.count, levels(source)) == (2, [0, 9])
    file = next((tmp_path / "bag").glob("*.mcap"))
    assert levels(open_pictures(file)) == [0, 9]


def test_a_damaged_picture_says_so_when_it_is_read(tmp_path):
    (tmp_path / "a.jpg").write_bytes(b"no image")
    (picture,) = open_pictures(tmp_path).pictures()
    with pytest.raises(InputError, match=r"a\.jpg cannot be read"):
        picture.read()
    cv2.imwrite(str(tmp_path / "a.jpg"), grey(5))
    (picture,) = open_pictures(tmp_path, max_pixels=1000).pictures()
    with pytest.raises(InputError, match="64 x 48 pixels"):
        picture.read()


def test_what_holds_no_pictures_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"does not exist; give images"):
        open_pictures(tmp_path / "nowhere")
    with pytest.raises(InputError, match=r"has no images .* and is not a bag"):
        open_pictures(tmp_path)
    with pytest.raises(InputError, match="has no images; it may be a simulated flight"):
        open_pictures(boxes_only(tmp_path))
    several = make_bag(tmp_path / "several", topics=("left/image_raw", "right/image_raw"))
    with pytest.raises(InputError, match=r"several topics \(/left/image_raw, /right/image_raw\)"):
        open_pictures(several)


def boxes_only(folder):
    with BagWriter(folder / "boxes") as bag:
        bag.write("height", "std_msgs/msg/Float64", 1, {"data": 1.0}, SENSOR)
    return folder / "boxes"
