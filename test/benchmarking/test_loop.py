# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A recording played to and fro: stamps go on, nothing jumps, nothing comes twice at once."""

from __future__ import annotations

import itertools

import pytest

from aerial_gnss_ros.adapters.stamps import header_fields, nanoseconds
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.writer import BagWriter
from aerial_gnss_ros.benchmarking.loop import Loop
from aerial_gnss_ros.core.values.errors import InputError

START, MS = 1_700_000_000_000_000_000, 1_000_000
IMAGE = {"height": 1, "width": 1, "encoding": "bgr8", "step": 3}


@pytest.fixture
def bag(tmp_path):
    """Write images at 0, 100, 200 ms (numbered by their first byte) and heights every 50 ms."""

    def write(images=(0, 100, 200)):
        path = tmp_path / "bag"
        with BagWriter(path) as made:
            for ms in range(-100, 301, 50):
                at = START + ms * MS
                made.write("height", "std_msgs/msg/Float64", at, {"data": float(ms)})
                if ms in images:
                    header = header_fields(at, "camera")
                    fields = {"header": header, "data": bytes([ms, 0, 0]), **IMAGE}
                    made.write("camera/image_raw", "sensor_msgs/msg/Image", at + 20 * MS, fields)
        return path

    return write


def played(path, count):
    with open_bag([path]) as opened:
        loop = Loop(opened, ["/height", "/camera/image_raw"], "/camera/image_raw")
        found = []
        for moment in itertools.islice(loop.moments(), count):
            message = moment.entry.message(START + moment.stamp_ns)
            if loop.is_image(moment):
                assert nanoseconds(message.header.stamp) == START + moment.stamp_ns
                assert message.header.frame_id == "camera"
                found.append((moment.due_ns // MS, moment.stamp_ns // MS, int(message.data[0])))
            else:
                found.append((moment.due_ns // MS, moment.stamp_ns // MS, message.data))
        return loop, found


def test_forward_then_backward_without_end(bag):
    loop, found = played(bag(), 36)
    images = [item for item in found if item[0] != item[1]]
    heights = [item for item in found if item[0] == item[1]]
    assert (loop.images, loop.rate_hz) == (3, 10.0)
    assert [stamp for _, stamp, _ in images] == list(range(0, 1200, 100))
    assert [which for _, _, which in images] == [0, 100, 200, 100] * 3
    assert all(due - stamp == 20 for due, stamp, _ in images)  # as late as recorded
    assert [due for due, _, _ in heights] == list(range(0, 1200, 50))
    assert [value for _, _, value in heights[:9]] == [0, 50, 100, 150, 200, 150, 100, 50, 0]
    assert [due for due, _, _ in found] == sorted(due for due, _, _ in found)


def test_the_bytes_differ_only_in_the_stamp(bag):
    with open_bag([bag()]) as opened:
        loop = Loop(opened, ["/camera/image_raw"], "/camera/image_raw")
        entry = next(loop.moments()).entry
        raw = entry.raw(START + 5 * 10**9 + 7)
        assert raw[:4] == entry.recorded.raw[:4]
        assert raw[12:] == entry.recorded.raw[12:]
        assert entry.raw(START) == entry.recorded.raw


def test_one_image_is_no_recording(bag):
    with pytest.raises(InputError, match="has 1 images on /camera/image_raw; at least two"):
        played(bag(images=(0,)), 1)
