# SPDX-License-Identifier: Apache-2.0
"""Looks at overlapping tiles of an image in full resolution: for 4K images with small robots."""

from __future__ import annotations

import time

from aerial_gnss_ros.detection.base import Detections, Detector, Image, Wrapper
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.pieces import detections, look, merge, reconsidered
from aerial_gnss_ros.detection.second_look import SecondLook, words
from aerial_gnss_ros.detection.windows import grid


class TilingDetector(Wrapper):
    """A Detector that shows another one an image tile by tile.

    Args:
        inner: looks at a tile.
        config: tile, overlap, the number of boxes, and with a second look their least score.
        second: looks again at what is found.
    """

    def __init__(
        self, inner: Detector, config: DetectorConfig, second: SecondLook | None = None
    ) -> None:
        super().__init__(inner)
        self._second = second
        self._threshold = config.score_threshold
        self._tile = min(config.search.tile, config.image_size)  # larger ones would be shrunk
        self._overlap = min(config.search.overlap, self._tile // 2)
        self._most = config.max_detections

    @property
    def name(self) -> str:
        """The inner detector's, and how it is used."""
        return f"{words(self._inner, self._second)}, in tiles of {self._tile} px"

    def detect(self, image: Image) -> Detections:
        """Return the boxes found in `image` (height, width, 3), blue, green, red."""
        windows = grid((image.shape[1], image.shape[0]), (self._tile, self._tile), self._overlap)
        pieces, spent = look(self._inner, image, windows)
        started = time.perf_counter()
        found = merge(pieces, windows)
        if self._second is not None:
            found = reconsidered(found, image, self._second, self._threshold)
        spent["post"] = spent.get("post", 0.0) + 1e3 * (time.perf_counter() - started)
        return detections(found, self.class_names, self._most, spent)
