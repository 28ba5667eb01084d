# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether boxes lie inside the images that the camera's description is of."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.estimation.intake import LONG_S
from aerial_gnss_ros.core.tracker.box_account import TUNING
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.events import Events


class ImageBounds:
    """Reports, once, a camera that describes smaller images than those with the boxes.

    Args:
        described_by: what describes the camera, in words.
        log: receives the sentence.
    """

    def __init__(self, described_by: str, log: Events) -> None:
        self._described_by = described_by
        self._log = log
        self._begin(0)

    def _begin(self, stamp_ns: int) -> None:
        self._since_ns, self._boxes, self._outside = stamp_ns, 0, 0

    def update(self, boxes: DetectionFrame, camera: CameraModel) -> None:
        """Take in an image's boxes, and judge those of `LONG_S` together: one may be false."""
        if not 0 <= boxes.stamp_ns - self._since_ns < LONG_S * 1e9:
            if self._boxes >= TUNING.least_refused and 2 * self._outside > self._boxes:
                self._tell(camera)
            self._begin(boxes.stamp_ns)
        size = camera.width, camera.height
        outside = (boxes.centers < 0.0) | (boxes.centers > size)
        self._outside += int(np.count_nonzero(outside.any(axis=1)))
        self._boxes += len(boxes)

    def _tell(self, camera: CameraModel) -> None:
        self._log.warn_once(
            "image bounds",
            f"{self._outside} of {self._boxes} boxes lie outside the {camera.width} x "
            f"{camera.height} px of {self._described_by}, and are refused "
            "(outside_calibrated_image): it describes smaller images than the detector is given.",
        )
