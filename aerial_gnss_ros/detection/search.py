# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The detector that processes the parts of an image which the configuration selects."""

from __future__ import annotations

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.roi import FollowingDetector
from aerial_gnss_ros.detection.search_config import FULL, TILES
from aerial_gnss_ros.detection.second_look import LookingTwice, SecondLook
from aerial_gnss_ros.detection.tiling import TilingDetector


def searching(
    detector: Detector, config: DetectorConfig, second: SecondLook | None = None
) -> Detector:
    """Return a detector that processes the parts that `config.search` selects.

    Args:
        detector: processes one image or part.
        config: of the detector.
        second: rescores uncertain boxes.

    Raises:
        ModelError: the model's input has a fixed size, so smaller parts would not be faster.
    """
    mode = config.search.mode
    if mode == FULL:
        if second is None:
            return detector
        return LookingTwice(detector, second, config.score_threshold)
    fixed = getattr(detector, "fixed_size", None)
    if fixed is not None:
        raise ModelError(
            f"{detector.name} takes images of {fixed[0]}x{fixed[1]} only, and search.mode {mode} "
            "needs a free size; export the model with one, or set search.mode to full."
        )
    if mode == TILES:
        return TilingDetector(detector, config, second)
    return FollowingDetector(detector, config, second)
