# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads labelled images from a simulated flight: a bag with images and their true labels."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from aerial_gnss_ros.adapters.canonical import detection_frame
from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.images import decode
from aerial_gnss_ros.text.json_text import parse_json
from aerial_gnss_ros.training.labelled import LabelledImage, Truth, truth_of_rows

_IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
_LABELS = "truth/labels"
_BOXES = "truth/detections"
_LEAST_LONG_PX, _LEAST_SHORT_PX = 16.0, 8.0


def is_bag(path: Path) -> bool:
    """Return whether `path` is a bag and not a folder of images."""
    return path.is_file() or (path / "metadata.yaml").is_file()


def read_bag(path: Path) -> Iterator[LabelledImage]:
    """Yield the images of a bag, each with the true labels that have its stamp.

    Robots count as in images of `simulation.dataset`: topic truth/labels has the same data as
    meta.csv. Bags without it have only truth/detections, which omits robots that are too faint or
    truncated: if detected, they count as false. There, robots with a box of at least 16 x 8 px
    count.

    Raises:
        InputError: not a bag, or one without images or true labels.
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
                truth = truths[stamp_ns]
                yield LabelledImage(f"{recorded.topic} {stamp_ns}", truth, partial(decode, message))


def _truths(path: Path) -> dict[int, Truth]:
    """Return the truth of the images, by their stamps."""
    with open_bag([path]) as bag:
        labels = {name for name in bag.topics if name.endswith(_LABELS)}
        if labels:
            return dict(_from_labels(path, str(r.message().data)) for r in bag.messages(labels))
        boxes = {name for name in bag.topics if name.endswith(_BOXES)}
        if not boxes:
            raise InputError(
                f"{path} has no topic {_LABELS} or {_BOXES}; only simulated flights have them."
            )
        frames = [detection_frame(recorded.message()) for recorded in bag.messages(boxes)]
    return {frame.stamp_ns: _from_boxes(frame) for frame in frames}


def _from_labels(path: Path, text: str) -> tuple[int, Truth]:
    """Return an image's stamp and the robots in it."""
    try:
        about = parse_json(text)
        return int(about["stamp_ns"]), truth_of_rows(about["robots"])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"{path}: {_LABELS} must have stamp_ns and the robots' boxes as `aerial-gnss simulate` "
            f"writes them, not {text[:60]!r}."
        ) from error


def _from_boxes(frame: DetectionFrame) -> Truth:
    long_px, short_px = frame.sizes.max(axis=1), frame.sizes.min(axis=1)
    return Truth(
        np.hstack([frame.centers - frame.sizes / 2, frame.centers + frame.sizes / 2]),
        (long_px >= _LEAST_LONG_PX) & (short_px >= _LEAST_SHORT_PX),
        long_px,
        np.full(len(frame), np.nan),
        np.zeros(len(frame), dtype=np.int64),  # the simulation knows one class
    )
