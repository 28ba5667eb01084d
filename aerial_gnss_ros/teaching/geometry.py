# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Moves pixels between frames whose camera poses are known: through the place on the water."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.errors import CameraError, InputError

Array = NDArray[np.float64]

_FLATTEST = 0.02
"""Least sine of the angle of a ray below the horizon."""
_MIDDLE = 0.5
"""From pixel edges, as in boxes, to pixel centres, as in camera models."""


@dataclass(frozen=True)
class View:
    """The camera of one frame.

    Attributes:
        camera: lens and image.
        position: (3,) East, North, Up of the water, m.
        rotation: (3, 3) from the optical frame to East, North, Up.
    """

    camera: CameraModel
    position: Array
    rotation: Array

    def place(self, pixels: Array) -> Array:
        """Return the places (n, 2) on the water, m, of pixels (n, 2); NaN at the horizon."""
        rays, valid = self.camera.rays(pixels - _MIDDLE)
        rays = rays @ self.rotation.T
        down = np.where(valid & (rays[:, 2] < -_FLATTEST), rays[:, 2], np.nan)
        return np.asarray(self.position[:2] - rays[:, :2] * (self.position[2] / down)[:, None])

    def pixel(self, places: Array) -> Array:
        """Return the pixels (n, 2) of places (n, 2) on the water; NaN behind the camera."""
        points = np.column_stack([places, np.zeros(len(places))]) - self.position
        pixels, valid = self.camera.project(points @ self.rotation)
        return np.where(valid[:, None], pixels + _MIDDLE, np.nan)

    def longer_side(self, box: Array) -> float:
        """Return the longer side of a box (4,) at its middle's distance, m; NaN at the horizon."""
        place = self.place(box[None, :2])[0]
        distance = np.linalg.norm([*(place - self.position[:2]), self.position[2]])
        half = np.diag(0.5 * box[2:])
        ends = np.concatenate([box[:2] - half, box[:2] + half]) - _MIDDLE
        rays, valid = self.camera.rays(ends)
        chords = np.linalg.norm(rays[2:] - rays[:2], axis=1)
        return float(distance * chords.max()) if valid.all() else float("nan")

    def as_dict(self) -> dict[str, Any]:
        """Return the view for JSON."""
        camera = self.camera
        return {
            "width": camera.width, "height": camera.height, "model": camera.model,
            "K": camera.K.tolist(), "D": camera.D.tolist(), "R": camera.R.tolist(),
            "rectified": camera.rectified,
            "position": self.position.tolist(), "rotation": self.rotation.tolist(),
        }  # fmt: skip


def view_of(content: dict[str, Any] | None) -> View | None:
    """Return the view of `View.as_dict`.

    Raises:
        InputError: it is damaged.
    """
    if content is None:
        return None
    try:
        camera = CameraModel(
            int(content["width"]), int(content["height"]), str(content["model"]),
            np.array(content["K"]), np.array(content["D"]), bool(content["rectified"]),
            np.array(content["R"]),
        )  # fmt: skip
        position = np.array(content["position"], dtype=np.float64).reshape(3)
        rotation = np.array(content["rotation"], dtype=np.float64).reshape(3, 3)
    except (KeyError, TypeError, ValueError, CameraError) as error:
        raise InputError(f"the camera of a frame is damaged ({error}).") from error
    return View(camera, position, rotation)


def moved(views: Sequence[View | None], first: int, second: int, points: Array) -> Array | None:
    """Return points (n, 2) px of one frame in another; None if a camera is unknown."""
    one, other = views[first], views[second]
    if one is None or other is None:
        return None
    places = one.place(points)
    if not np.isfinite(places).all():
        return np.full_like(points, np.nan)
    return other.pixel(places)
