# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The boxes of one image, as adapters pass them to the estimator."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class DetectionFrame:
    """All boxes of one image.

    Attributes:
        stamp_ns: the image's stamp, ns.
        frame_id: the image's frame, copied.
        centers: (n, 2) box centres u, v in pixels of the source image.
        sizes: (n, 2) box widths and heights, px.
        scores: (n,) 0 to 1.
        class_ids: n class names.
    """

    stamp_ns: int
    frame_id: str
    centers: Array
    sizes: Array
    scores: Array
    class_ids: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.class_ids)

    def keep(self, mask: NDArray[np.bool_]) -> DetectionFrame:
        """Return the detections where `mask` (n,) is true."""
        return self.rows(np.flatnonzero(mask).tolist())

    def rows(self, rows: list[int]) -> DetectionFrame:
        """Return the detections of these rows in ascending order; the frame itself if all."""
        if len(rows) == len(self.class_ids):
            return self
        return DetectionFrame(
            self.stamp_ns,
            self.frame_id,
            self.centers[rows],
            self.sizes[rows],
            self.scores[rows],
            tuple(self.class_ids[i] for i in rows),
        )


def empty_detections(stamp_ns: int, frame_id: str = "camera") -> DetectionFrame:
    """Return the frame of an image without boxes."""
    return DetectionFrame(stamp_ns, frame_id, np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), ())
