# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images of a recording by time, with the boxes of the same image."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.bags.writer import RELIABLE, SENSOR, BagWriter
from aerial_gnss_ros.view.pictures import WIDTH_PX, RecordedPictures, packed

BEGIN, STEP, LATER = 1_700_000_000_000_000_000, 200_000_000, 3_000_000_000_000
SIZE = (32, 1920)  # height and width


def write(folder, topic="camera/image_raw", boxes=True):
    """Write a bag whose recorder's clock is 50 minutes ahead; image i has a brightness of 10 i."""
    with BagWriter(folder / "bag") as bag:
        for i in range(20):
            header = header_fields(BEGIN + i * STEP, "camera")
            log_ns = BEGIN + i * STEP + LATER
            height, width = SIZE
            image = {
                "header": header,
                "height": height,
                "width": width,
                "encoding": "mono8",
                "step": width,
                "data": np.full(height * width, 10 * i, dtype=np.uint8),
            }
            bag.write(topic, "sensor_msgs/msg/Image", log_ns, image, SENSOR)
            if boxes and i % 2 == 0:
                result = {"hypothesis": {"class_id": "aqua", "score": 0.5}}
                box = {"center": {"position": {"x": float(i), "y": 4.0}}, "size_x": 2.0}
                found = {"header": header, "detections": [{"results": [result], "bbox": box}]}
                bag.write(
                    "detections", "vision_msgs/msg/Detection2DArray", log_ns + 9, found, RELIABLE
                )
    return [folder / "bag"]


@pytest.fixture
def pictures():
    """Return a function that opens the images of bags."""
    opened = []

    def make(paths):
        opened.append(RecordedPictures(paths, "camera/image_raw", "detections", ""))
        return opened[-1]

    yield make
    for one in opened:
        one.close()


def test_the_nearest_image_comes_small_with_its_own_size_and_boxes(tmp_path, pictures):
    shown = pictures(write(tmp_path))
    assert shown.find() == "/camera/image_raw"
    content, header, boxes = shown.at(BEGIN + 6 * STEP + 30_000_000).result()
    image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert image.shape == (16, WIDTH_PX)
    assert abs(float(image.mean()) - 60.0) < 2.0
    assert header == {
        "stamp_ns": BEGIN + 6 * STEP, "width": 1920, "height": 32, "boxes_known": True
    }  # fmt: skip
    assert [box.x for box in boxes] == [6.0]


def test_boxes_of_another_image_are_not_shown(tmp_path, pictures):
    shown = pictures(write(tmp_path))
    shown.find()
    _, header, boxes = shown.at(BEGIN + 7 * STEP).result()
    assert (header["stamp_ns"], header["boxes_known"], boxes) == (BEGIN + 7 * STEP, False, [])


def test_far_from_all_images_there_is_none(tmp_path, pictures):
    shown = pictures(write(tmp_path))
    shown.find()
    assert shown.at(BEGIN + 60 * STEP).result() is None
    assert shown.at(BEGIN + 24 * STEP).result()[1]["stamp_ns"] == BEGIN + 19 * STEP


def test_images_on_another_topic_are_found(tmp_path, pictures):
    shown = pictures(write(tmp_path, topic="front/image", boxes=False))
    assert shown.find() == "/front/image"
    assert shown.at(BEGIN).result()[1]["boxes_known"] is False


def test_a_picture_is_packed_behind_its_header():
    whole = packed(b"JPEG", {"width": 5})
    length = int.from_bytes(whole[:4], "little")
    assert json.loads(whole[4 : 4 + length]) == {"kind": "picture", "width": 5}
    assert whole[4 + length :] == b"JPEG"
