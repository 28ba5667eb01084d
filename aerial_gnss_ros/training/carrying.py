# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Transforms boxes with an image that is warped by a matrix.

A box states only an object's extent. The box around the four transformed corners is right only if
the object fills its box; for others it is too large: by 17 % in area for the simulated hexapod
turned by up to 10 deg. So a robot is modelled as the ellipse that touches the centres of its box's
sides, for which that figure is 0 % (python benchmarks/box_rotation.py). Both agree and are exact
for any object if axes stay axes: flips, quarter turns, scale, crops and padding.

A box is transformed once, from the labelled to the final image, by the product of all matrices:
step by step it would grow with every rotation.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ANGLES = np.linspace(0.0, 2.0 * np.pi, 128, endpoint=False)
_CIRCLE = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)


def carry(boxes: Array, matrix: Array, seen: Array) -> Array:
    """Return the boxes of the visible part of each object.

    Args:
        boxes: (n, 4) centre x, y, width, height, px, first pixel spans 0 to 1.
        matrix: (3, 3) affine, from the labelled image to the finished one.
        seen: (m, 2) convex outline of the rest of the labelled image, in the final one.

    Returns:
        (n, 4) centre x, y, width, height in the finished image; width and height are 0 if nothing
        is visible.
    """
    carried = np.zeros((len(boxes), 4))
    for i, (x, y, width, height) in enumerate(boxes):
        outline = moved(np.array([x, y]) + _CIRCLE * (width / 2, height / 2), matrix)
        if not _inside(outline, seen):
            outline = cut(outline, seen)
        if len(outline):
            low, high = outline.min(axis=0), outline.max(axis=0)
            carried[i] = [*(low + high) / 2, *(high - low)]
    return carried


def moved(points: Array, matrix: Array) -> Array:
    """Return points (n, 2) after the affine matrix (3, 3)."""
    return np.asarray(points @ matrix[:2, :2].T + matrix[:2, 2])


def cut(outline: Array, window: Array) -> Array:
    """Return the part of a convex outline (n, 2) inside another (m, 2); (0, 2) if none is.

    Half-plane by half-plane (I. Sutherland and G. Hodgman, 1974). OpenCV's intersectConvexConvex
    sometimes returns nothing if the two share part of a border, as for a robot labelled at the edge
    of the image.
    """
    part = np.asarray(outline, dtype=np.float64)
    following = np.roll(window, -1, axis=0)
    turn = np.sign((window[:, 0] * following[:, 1] - following[:, 0] * window[:, 1]).sum())
    for corner, edge in zip(window, turn * (following - window), strict=True):
        inward = edge[0] * (part[:, 1] - corner[1]) - edge[1] * (part[:, 0] - corner[0])
        inside, after = inward >= 0.0, np.roll(inward, -1)
        crosses = inside != (after >= 0.0)
        share = inward / np.where(crosses, inward - after, 1.0)
        crossings = part + share[:, None] * (np.roll(part, -1, axis=0) - part)
        kept = np.stack([inside, crosses], axis=1)
        part = np.stack([part, crossings], axis=1)[kept]
        if len(part) < 3:
            return np.zeros((0, 2))
    return part


def rectangle(width: float, height: float) -> Array:
    """Return the outline (4, 2) of a canvas."""
    return np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])


def _inside(points: Array, window: Array) -> bool:
    """Whether all points lie in the convex window, whichever way its outline runs."""
    edges = np.roll(window, -1, axis=0) - window
    to_points = points[:, None, :] - window[None, :, :]
    side = edges[:, 0] * to_points[..., 1] - edges[:, 1] * to_points[..., 0]
    return bool((side >= -1e-6).all() or (side <= 1e-6).all())
