# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which parts of an image the network processes: the parameters."""

from __future__ import annotations

from dataclasses import dataclass

from aerial_gnss_ros.core.config.schema import key

FULL, ROI, TILES = "full", "roi", "tiles"


@dataclass(frozen=True)
class SearchConfig:
    """Which parts of an image the network processes."""

    mode: str = key(
        FULL,
        "full: the whole image, reduced to image_size if larger. roi: around the predicted "
        "position of each robot, and one part of the remaining image per frame, in turn; several "
        "times as fast, but a robot that enters the view is detected only after up to scan_images "
        "images. tiles: overlapping tiles in full resolution, all of them in each image; slow, "
        "for 4K images with small robots. roi and tiles need a model with a free input size.",
        choices=(FULL, ROI, TILES),
    )
    scan_images: int = key(
        15,
        "With roi: number of images in which the whole view is scanned once, a part in each; 15 "
        "is half a second at 30 images a second. More is faster and detects robots that enter the "
        "view later. 1 processes whole images only.",
        low=1,
        high=300,
    )
    margin: int = key(
        32,
        "With roi: margin around each robot. Lower is faster, and loses robots when the camera "
        "turns quickly: the margin is the greatest change of their motion from one image to the "
        "next.",
        unit="px",
        low=8,
        high=1000,
    )
    tile: int = key(
        1280,
        "With tiles: longest side of a tile. Smaller tiles take no less time in total; on a CPU "
        "the default is right.",
        unit="px",
        low=128,
        high=4096,
    )
    overlap: int = key(
        64,
        "Least overlap of neighbouring tiles (tiles) or parts (roi). Longer robots are merged from "
        "two halves (tiles), or detected one image later (roi).",
        unit="px",
        low=0,
        high=1000,
    )
