# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The camera's image for the page: a small JPEG behind a JSON header."""

from __future__ import annotations

import json
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.bags.plan import COMPRESSED, IMAGE, resolve
from aerial_gnss_ros.bags.reader import BagReader, open_bag
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.images import decode
from aerial_gnss_ros.view.scene import Box, boxes_of

WIDTH_PX = 960
QUALITY = 70
ARRAY = "vision_msgs/msg/Detection2DArray"
SAME_NS = 1_000_000
"""Stamps of an image and of its boxes differ by less than that."""
_WINDOWS_NS = (150_000_000, 1_500_000_000)
"""How far from a stamp images are looked for: first nearby, since reading them costs time."""


def jpeg(message: Any) -> tuple[bytes, int, int]:
    """Return an image as a JPEG of at most `WIDTH_PX` columns, and its own width and height.

    Args:
        message: a sensor_msgs Image or CompressedImage.

    Raises:
        InputError: it cannot be decoded.
    """
    image = decode(message)
    height, width = image.shape[:2]
    if width > WIDTH_PX:
        size = (WIDTH_PX, max(1, round(height * WIDTH_PX / width)))
        image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
    done, encoded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    if not done:
        raise InputError("the image cannot be encoded as JPEG.")
    return encoded.tobytes(), width, height


def packed(content: bytes, header: dict[str, Any]) -> bytes:
    """Return what the page receives: the header's length (4 bytes, little endian), header, JPEG."""
    text = json.dumps({"kind": "picture", **header}).encode()
    return len(text).to_bytes(4, "little") + text + content


class RecordedPictures:
    """Images of a recording by time; all methods but `close` run in a thread of their own.

    Args:
        paths: the bags.
        topic: of raw images, relative or absolute; compressed ones are below it. Another topic with
            images serves if these have none.
        boxes: topic of the boxes.
        namespace: of relative topics.
    """

    def __init__(self, paths: Sequence[Path], topic: str, boxes: str, namespace: str) -> None:
        self._paths, self._namespace = list(paths), namespace
        self._wanted, self._boxes = topic, resolve(boxes, namespace)
        self._bag: BagReader | None = None
        self._topic = ""
        self._later_ns = 0
        self._thread = ThreadPoolExecutor(max_workers=1)

    def find(self) -> str:
        """Return the topic with images; empty if there is none."""
        return self._thread.submit(self._open).result()

    def at(self, stamp_ns: int) -> Any:
        """Return a future of the image nearest to a stamp, with its boxes; None if there is none.

        Its result is (JPEG, header, boxes).
        """
        return self._thread.submit(self._at, stamp_ns)

    def close(self) -> None:
        """Close the bags."""
        self._thread.submit(self._close).result()
        self._thread.shutdown()

    def _open(self) -> str:
        bag = open_bag(self._paths)
        self._bag = bag.__enter__()
        raw = resolve(self._wanted, self._namespace)
        images = {
            name: kind.msgtype
            for name, kind in bag.topics.items()
            if kind.count and kind.msgtype in (IMAGE, COMPRESSED)
        }
        known = [name for name in (raw, f"{raw}/compressed") if name in images]
        self._topic = next(iter([*known, *images]), "")
        if self._topic:
            first = next(iter(bag.messages({self._topic})))
            self._later_ns = first.log_ns - nanoseconds(first.message().header.stamp)
        return self._topic

    def _close(self) -> None:
        if self._bag is not None:
            self._bag.__exit__(None, None, None)

    def _at(self, stamp_ns: int) -> tuple[bytes, dict[str, Any], list[Box]] | None:
        found = self._nearest(self._topic, stamp_ns)
        if found is None:
            return None
        own_ns = nanoseconds(found.header.stamp)
        content, width, height = jpeg(found)
        array = self._nearest(self._boxes, own_ns)
        same = array is not None and abs(nanoseconds(array.header.stamp) - own_ns) < SAME_NS
        header = {"stamp_ns": own_ns, "width": width, "height": height, "boxes_known": same}
        return content, header, boxes_of(array) if same else []

    def _nearest(self, topic: str, stamp_ns: int) -> Any:
        """Return the message of a topic whose stamp is nearest to a stamp; None: none is near."""
        if self._bag is None or topic not in self._bag.topics:
            return None
        about_ns = stamp_ns + self._later_ns
        for window_ns in _WINDOWS_NS:
            best, nearest_ns = None, window_ns
            for recorded in self._bag.messages({topic}, about_ns - window_ns, about_ns + window_ns):
                message = recorded.message()
                away_ns = abs(nanoseconds(message.header.stamp) - stamp_ns)
                if away_ns < nearest_ns:
                    best, nearest_ns = message, away_ns
            if best is not None:
                return best
        return None
