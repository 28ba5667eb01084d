# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images whose boxes updated robots: detection rate of robots and density of clutter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ImageHistoryTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    prior_new_boxes: float = 0.1
    """Prior number of detections of no known robot in an image. Judged."""
    prior_hits: float = 9.0
    """Prior count of detected robots: nine of ten. Judged."""
    prior_misses: float = 1.0
    """Prior count of missed robots: one of ten. Judged."""


TUNING = ImageHistoryTuning()


class Seen(NamedTuple):
    """An image whose boxes updated robots.

    Attributes:
        stamp_ns: of the image.
        centers: (m, 2) of its boxes, px.
        class_ids: of these.
        named: by box, the label of the robot that it updated.
        camera: lens and image size.
        height: of the camera above the water, m.
    """

    stamp_ns: int
    centers: Array
    class_ids: tuple[str, ...]
    named: dict[int, str]
    camera: CameraModel
    height: float


def detection_rates(history: Sequence[Seen]) -> tuple[float, float]:
    """Return the detection probability and the density of other detections.

    Args:
        history: the last images whose boxes measured robots.
    """
    camera = history[-1].camera
    names = {name for seen in history for name in seen.named.values()}
    hits = sum(len(seen.named) for seen in history)
    others = sum(len(seen.centers) - len(seen.named) for seen in history)
    share = (hits + TUNING.prior_hits) / (
        len(names) * len(history) + TUNING.prior_hits + TUNING.prior_misses
    )
    area = float(camera.width * camera.height / (camera.K[0, 0] * camera.K[1, 1]))
    return min(share, 0.99), (TUNING.prior_new_boxes + others / len(history)) / area
