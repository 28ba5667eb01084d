# SPDX-License-Identifier: Apache-2.0
"""Reads labelled images from a simulated flight: a bag with images and truth/detections."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from aerial_gnss_ros.adapters.canonical import detection_frame
from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.core.errors import InputError
from aerial_gnss_ros.core.values import DetectionFrame
from aerial_gnss_ros.detection.images import decode
from aerial_gnss_ros.training.labelled import LabelledImage, Truth

_IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
_TRUTH = "truth/detections"
_LEAST_LONG_PX, _LEAST_SHORT_PX = 16.0, 8.0


def is_bag(path: Path) -> bool:
    """Return whether `path` is a bag and not a folder of images."""
    return path.is_file() or (path / "metadata.yaml").is_file()


def read_bag(path: Path) -> Iterator[LabelledImage]:
    """Yield the images of a bag, each with the true boxes that have its stamp.

    Robots whose box is smaller than 16 x 8 px do not count. Those that the simulation does not
    list, because they are too faint or cut off, are unknown here: found, they count as false.

    Raises:
        InputError: not a bag, or one without images or true boxes.
    """
    truths = _truths(path)
    with open_bag([path]) as bag:
        topics = {topic.name for topic in bag.topics.values() if topic.msgtype in _IMAGES}
        if not topics:
            raise InputError(f"{path} has no images; simulate it without --no-images.")
        for recorded in bag.messages(topics):
            message = recorded.message()
            stamp_ns = nanoseconds(message.header.stamp)
            if stamp_ns in truths:
                truth = _truth(truths[stamp_ns])
                yield LabelledImage(f"{recorded.topic} {stamp_ns}", truth, partial(decode, message))


def _truths(path: Path) -> dict[int, DetectionFrame]:
    with open_bag([path]) as bag:
        topics = {name for name in bag.topics if name.endswith(_TRUTH)}
        if not topics:
            raise InputError(f"{path} has no topic {_TRUTH}; only simulated flights have it.")
        frames = [detection_frame(recorded.message()) for recorded in bag.messages(topics)]
    return {frame.stamp_ns: frame for frame in frames}


def _truth(frame: DetectionFrame) -> Truth:
    long_px, short_px = frame.sizes.max(axis=1), frame.sizes.min(axis=1)
    return Truth(
        np.hstack([frame.centers - frame.sizes / 2, frame.centers + frame.sizes / 2]),
        (long_px >= _LEAST_LONG_PX) & (short_px >= _LEAST_SHORT_PX),
        long_px,
        np.full(len(frame), np.nan),
        np.zeros(len(frame), dtype=np.int64),  # the simulation knows one class
    )
