# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One image's detections as measurements on the water."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.geometry.geodesy import LocalMap, on_water_surface
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints
from aerial_gnss_ros.core.numerics.small_arrays import MAX_ROWS
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame

Array = NDArray[np.float64]


EDGE = 0.06
"""Width of the image's edge, as a share of its smaller side: a robot's motion between images, or
half of its box."""


@dataclass(frozen=True)
class Measurements:
    """The detections of one image that have a point on the water.

    Attributes:
        index: (m,) row in the image's detections.
        pixels: (m, 2) centres of the boxes, px; refraction of robots below the surface taken out.
        positions: (m, 2) East, North in `map`, m.
        white: (m, 2, 2) white covariance, m².
        class_ids: (m,) class names.
        edge: (m,) whether they are at the image's edge, where they may enter or leave.
        points: (m, 3) East, North, Up in `map`: the water is below its plane, m.
    """

    index: NDArray[np.intp]
    pixels: Array
    positions: Array
    white: Array
    class_ids: NDArray[np.str_]
    edge: NDArray[np.bool_]
    points: Array

    def moved(self, step: Array) -> Measurements:
        """Return them on water that is displaced by (3,) m."""
        if not any(step.tolist()):
            return self
        return replace(self, positions=self.positions + step[:2], points=self.points + step)


def measurements(
    frame: PosedFrame, points: WaterPoints, local: LocalMap, level: float = 1.0
) -> Measurements:
    """Return the detections that have a point, in `map`.

    Args:
        frame: the image.
        points: positions of its boxes on the water.
        local: the frame `map`.
        level: factor by which white noise is larger than stated, see `noise_level`.
    """
    whole = points.reasons.count(None) == len(points.reasons)
    index = np.arange(len(points.reasons)) if whole else np.flatnonzero(points.valid)
    kept = slice(None) if whole else index
    pixels, class_ids = points.pixels[kept], frame.detections.class_ids
    edge = at_edge(pixels, frame.camera.width, frame.camera.height)
    names = np.array([class_ids[i] for i in index.tolist()], dtype=str)
    positions = local.positions(points.latitude[kept], points.longitude[kept])
    white = level * points.covariance_white[kept]
    on_surface = on_water_surface(positions)
    return Measurements(index, pixels, positions, white, names, edge, on_surface)


def at_edge(pixels: Array, width: int, height: int) -> NDArray[np.bool_]:
    """Return which boxes (m,) are at the image's edge, where they may enter or leave.

    Args:
        pixels: (m, 2) their centres.
        width: of the image, px.
        height: likewise.
    """
    near = EDGE * min(width, height)
    if len(pixels) <= MAX_ROWS:
        right, low, rows = width - near, height - near, pixels.tolist()
        beside = [u < near or v < near or u > right or v > low for u, v in rows]
        return np.array(beside, np.bool_)
    close = (pixels < near) | (pixels > (width - near, height - near))
    edge: NDArray[np.bool_] = close[:, 0] | close[:, 1]
    return edge


def inside_any(frame: DetectionFrame, index: int, used: list[int]) -> bool:
    """Return whether a box's centre is inside a used box of its class."""
    same = [other for other in used if frame.class_ids[other] == frame.class_ids[index]]
    if not same:
        return False
    apart = np.abs(frame.centers[same] - frame.centers[index])
    return bool(np.any(np.all(apart < 0.5 * frame.sizes[same], axis=1)))
