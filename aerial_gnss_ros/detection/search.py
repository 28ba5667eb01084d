# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where in an image the network looks: its parameters, and the detector that they make."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from aerial_gnss_ros.core.config.schema import key
from aerial_gnss_ros.core.values.errors import ModelError

if TYPE_CHECKING:
    from aerial_gnss_ros.detection.base import Detector
    from aerial_gnss_ros.detection.config import DetectorConfig
    from aerial_gnss_ros.detection.second_look import SecondLook

FULL, ROI, TILES = "full", "roi", "tiles"


@dataclass(frozen=True)
class SearchConfig:
    """Where in an image the network looks."""

    mode: str = key(
        FULL,
        "full: at the whole image, shrunk to image_size where it is larger. roi: round each robot "
        "where it must be now, and at one part of the rest an image, in turn; several times as "
        "fast, but a robot that comes into view is found only after up to scan_images images. "
        "tiles: at overlapping tiles in full resolution, all of them every time; slow, for 4K "
        "images in which robots are small. roi and tiles need a model whose input size is free.",
        choices=(FULL, ROI, TILES),
    )
    scan_images: int = key(
        15,
        "With roi: the whole image is looked at once in this many images, a part in each; 15 is "
        "half a second at 30 images a second. Higher is faster and finds a robot that comes into "
        "view later. 1 looks at whole images only.",
        low=1,
        high=300,
    )
    margin: int = key(
        32,
        "With roi: water round each robot that the network sees too. Lower is faster, and loses "
        "robots when the camera turns quickly: they may move by this much more in an image than "
        "in the one before.",
        unit="px",
        low=8,
        high=1000,
    )
    tile: int = key(
        1280,
        "With tiles: longest side of a tile. Smaller tiles take no less time in all; on a "
        "processor the default is right.",
        unit="px",
        low=128,
        high=4096,
    )
    overlap: int = key(
        64,
        "Neighbouring tiles (tiles) or parts (roi) share at least this much. Robots longer than "
        "that are put together from two halves (tiles), or found one image later (roi).",
        unit="px",
        low=0,
        high=1000,
    )


def searching(
    detector: Detector, config: DetectorConfig, second: SecondLook | None = None
) -> Detector:
    """Return a detector that looks where `config.search` says.

    Args:
        detector: looks at what it is given.
        config: of the detector.
        second: looks again at the boxes that it is not sure of.

    Raises:
        ModelError: the model's input has one size, so that smaller parts would not be faster.
    """
    mode = config.search.mode
    if mode == FULL:
        if second is None:
            return detector
        from aerial_gnss_ros.detection.second_look import LookingTwice

        return LookingTwice(detector, second, config.score_threshold)
    fixed = getattr(detector, "fixed_size", None)
    if fixed is not None:
        raise ModelError(
            f"{detector.name} takes images of {fixed[0]}x{fixed[1]} only, and search.mode {mode} "
            "needs a free size; export the model with one, or set search.mode to full."
        )
    if mode == TILES:
        from aerial_gnss_ros.detection.tiling import TilingDetector

        return TilingDetector(detector, config, second)
    from aerial_gnss_ros.detection.roi import FollowingDetector

    return FollowingDetector(detector, config, second)
