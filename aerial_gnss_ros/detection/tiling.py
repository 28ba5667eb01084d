# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Processes overlapping tiles of an image in full resolution: for 4K images with small robots."""

from __future__ import annotations

from aerial_gnss_ros.detection.base import Detections, Detector, Image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.pieces import detections
from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.windowed import WindowedDetector
from aerial_gnss_ros.detection.windows import grid


class TilingDetector(WindowedDetector):
    """A Detector that passes an image to another one tile by tile.

    Args:
        inner: processes a tile.
        config: tile, overlap, the number of boxes, and with a second look their least score.
        second: rescores uncertain boxes.
    """

    def __init__(
        self, inner: Detector, config: DetectorConfig, second: SecondLook | None = None
    ) -> None:
        super().__init__(inner, config, second)
        self._tile = min(config.search.tile, config.image_size)  # larger ones would be shrunk
        self._overlap = min(config.search.overlap, self._tile // 2)

    @property
    def name(self) -> str:
        """The inner detector's name, and the search mode."""
        return f"{self._looking}, in tiles of {self._tile} px"

    def detect(self, image: Image) -> Detections:
        """Return the boxes found in `image` (height, width, 3), blue, green, red."""
        windows = grid((image.shape[1], image.shape[0]), (self._tile, self._tile), self._overlap)
        found, spent = self._look(image, windows)
        return detections(found, self.class_names, self._config.max_detections, spent)
