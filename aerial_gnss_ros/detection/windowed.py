# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Base of Detectors that pass windows of an image to another one."""

from __future__ import annotations

import time
from collections.abc import Sequence

from aerial_gnss_ros.detection.base import Detector, Image, Wrapper
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.pieces import Piece, look, merge, reconsidered
from aerial_gnss_ros.detection.second_look import SecondLook, words
from aerial_gnss_ros.detection.windows import Window


class WindowedDetector(Wrapper):
    """Passes windows to another Detector, and its boxes to the second look.

    Args:
        inner: processes a window.
        config: how to search, the number of boxes, and with a second look their least score.
        second: rescores uncertain boxes.
    """

    def __init__(
        self, inner: Detector, config: DetectorConfig, second: SecondLook | None = None
    ) -> None:
        super().__init__(inner)
        self._config = config
        self._second = second

    @property
    def _looking(self) -> str:
        """The detectors, in words."""
        return words(self._inner, self._second)

    def _look(
        self, image: Image, windows: Sequence[Window]
    ) -> tuple[list[Piece], dict[str, float]]:
        """Return each robot once, best score first, and the milliseconds of each stage."""
        pieces, spent = look(self._inner, image, windows)
        started = time.perf_counter()
        found = merge(pieces, windows)
        if self._second is not None:
            found = reconsidered(found, image, self._second, self._config.score_threshold)
        spent["post"] = spent.get("post", 0.0) + 1e3 * (time.perf_counter() - started)
        return found, spent
