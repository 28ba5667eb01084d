# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Truth about each robot in a rendered image: its box, size, contrast and visible share."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.view import Window

MIN_CONTRAST = 0.06
"""Least contrast of robots that count in scoring a detector: a person who does not know where to
look misses many fainter ones among waves (judged before any detector was trained)."""
MIN_LONG_PX, MIN_SHORT_PX = 16.0, 8.0
"""Least size of robots that count, px; smaller ones are scored separately, by size."""
MIN_VISIBLE = 0.5
"""Least visible share of robots that count."""


@dataclass(frozen=True)
class RobotLabel:
    """One robot in one image.

    Pixel coordinates are OpenCV's: the centre of the first pixel is (0, 0), the image reaches from
    -0.5 to width - 0.5.

    Attributes:
        robot_id, class_name: As in the robot's state.
        left, top, right, bottom: Edges of the visible projection clipped to the image, px.
        long_px, short_px: Sides of the smallest turned rectangle round the whole projection, px.
        depth: m of the hull's middle below the surface.
        contrast: Mean over the robot's pixels and the three colours of the absolute difference
            between the picture with and without it (8 bit values before noise), over 255.
        visible: Share of the projected area that is inside the image and not behind another.
        pixel: (u, v) at which the point of the mean water surface above the middle appears.
    """

    robot_id: str
    class_name: str
    left: float
    top: float
    right: float
    bottom: float
    long_px: float
    short_px: float
    depth: float
    contrast: float
    visible: float
    pixel: tuple[float, float]

    @property
    def xywh(self) -> tuple[float, float, float, float]:
        """Centre and size of the box, px."""
        return (
            0.5 * (self.left + self.right),
            0.5 * (self.top + self.bottom),
            self.right - self.left,
            self.bottom - self.top,
        )

    @property
    def clear(self) -> bool:
        """Whether it is visible enough, whatever its size (contrast, visible share)."""
        return self.contrast >= MIN_CONTRAST and self.visible >= MIN_VISIBLE

    @property
    def scored(self) -> bool:
        """Whether a detector is expected to detect it (size, contrast, visible share)."""
        return self.clear and self.long_px >= MIN_LONG_PX and self.short_px >= MIN_SHORT_PX

    def figures(self) -> dict[str, float]:
        """Figures for scoring, rounded, by the names of meta.csv's columns."""
        return {
            "scored": int(self.scored),
            "left": round(self.left, 2),
            "top": round(self.top, 2),
            "right": round(self.right, 2),
            "bottom": round(self.bottom, 2),
            "long_px": round(self.long_px, 2),
            "short_px": round(self.short_px, 2),
            "depth_m": round(self.depth, 3),
            "contrast": round(self.contrast, 4),
            "visible": round(self.visible, 3),
        }


def turned_size(pixels: NDArray[np.float64]) -> tuple[float, float]:
    """Long and short side in px of the smallest turned rectangle round points (n, 2)."""
    _, sides, _ = cv2.minAreaRect(pixels.astype(np.float32))
    return float(max(sides)), float(min(sides))


def box_of_points(
    pixels: NDArray[np.float64], image: Window
) -> tuple[float, float, float, float] | None:
    """Bounds of the convex hull of points clipped to an image (edges at half pixels), or None.

    The hull is clipped, not only its bounds, so parts outside the image do not widen the box.
    """
    hull = cv2.convexHull(pixels.astype(np.float32)).reshape(-1, 2).astype(np.float64)
    for axis, limit, keep_above in (
        (0, image.x - 0.5, True),
        (0, image.x + image.width - 0.5, False),
        (1, image.y - 0.5, True),
        (1, image.y + image.height - 0.5, False),
    ):
        hull = _clip(hull, axis, limit, keep_above)
        if len(hull) == 0:
            return None
    low, high = hull.min(axis=0), hull.max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _clip(
    polygon: NDArray[np.float64], axis: int, limit: float, keep_above: bool
) -> NDArray[np.float64]:
    sign = 1.0 if keep_above else -1.0
    inside = sign * (polygon[:, axis] - limit) >= 0.0
    if inside.all():
        return polygon
    kept: list[NDArray[np.float64]] = []
    for i in range(len(polygon)):
        j = (i + 1) % len(polygon)
        if inside[i]:
            kept.append(polygon[i])
        if inside[i] != inside[j]:
            share = (limit - polygon[i, axis]) / (polygon[j, axis] - polygon[i, axis])
            kept.append(polygon[i] + share * (polygon[j] - polygon[i]))
    return np.array(kept).reshape(-1, 2)
