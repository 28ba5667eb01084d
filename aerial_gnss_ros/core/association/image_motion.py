# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Camera motion in the image plane from one image to the next, as an affine map.

Coordinates are those of the plane at distance 1 before the camera, so that lengths are angles (rad)
near the axis:

    point + [1, 0, x, y, 0, 0; 0, 1, 0, 0, x, y] motion

Rotations of the camera and its translation shift the image; the linear part is a rotation about the
optical axis, a change of distance, and the variation of the water's distance over the image.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ImageMotionTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    rate_change_sigma: float = 0.35
    """Change of the motion's rates from image to image, one sigma, 1/s: rotations of 20 deg/s, or
    the same share of the distance. Judged."""
    shear_share: float = 0.25
    """The same for shear and anisotropic scale, as a share of `rate_change_sigma`: these arise from
    a drone's acceleration and change slower. Judged."""
    cut_off_coordinates: float = 10.0
    """Coordinates of a box outside the image are limited to this. Judged."""


TUNING = ImageMotionTuning()


class Motion(NamedTuple):
    """Affine motion of the image.

    Attributes:
        mean: (6,) parameters, see the module.
        covariance: (6, 6) of it.
    """

    mean: Array
    covariance: Array


def by_motion(points: Array) -> Array:
    """Return the derivatives (n, 2, 6) of points (n, 2) by the camera's motion."""
    matrix = np.zeros((len(points), 2, 6))
    matrix[:, 0, 0] = matrix[:, 1, 1] = 1.0
    matrix[:, 0, 2:4] = matrix[:, 1, 4:6] = points
    return matrix


def moved(points: Array, motion: Motion) -> Array:
    """Return points (n, 2) after a motion."""
    after: Array = points + by_motion(points) @ motion.mean
    return after


def fitted(points: Array, after: Array, variances: Array, motion: Motion) -> Motion:
    """Return the motion estimated from points (n, 2) and their positions in the next image.

    Args:
        points: previous positions.
        after: present positions.
        variances: (n,) as for `links`.
        motion: predicted motion of the camera.
    """
    weighted = by_motion(points) / variances[:, None, None]
    info = np.linalg.inv(motion.covariance) + np.einsum("nak,nal->kl", weighted, by_motion(points))
    covariance = np.linalg.inv(info)
    pull = np.einsum("nak,na->k", weighted, after - moved(points, motion))
    return Motion(motion.mean + covariance @ pull, covariance)


def _change_of_rates() -> Array:
    """Return the covariance (6, 6) of the changes of the camera's rates, 1/s²."""
    swap = np.array([[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, -1.0, 0.0], [0.0, -1.0, 0.0, 0.0],
                     [1.0, 0.0, 0.0, 0.0]])  # fmt: skip
    covariance = TUNING.rate_change_sigma**2 * np.eye(6)
    alike = 0.5 * (np.eye(4) + swap)  # rotations and scales; the rest are shears
    covariance[2:, 2:] = TUNING.rate_change_sigma**2 * (
        alike + TUNING.shear_share**2 * (np.eye(4) - alike)
    )
    return covariance


CHANGE = _change_of_rates()
"""… of which this is the covariance (6, 6), 1/s²."""


def on_plane(centers: Array, camera: CameraModel) -> Array:
    """Return pixels (n, 2) on the plane at distance 1, ignoring lens distortion."""
    K = camera.K
    plane = (centers - K[:2, 2]) / np.array([K[0, 0], K[1, 1]])
    near: Array = np.clip(plane, -TUNING.cut_off_coordinates, TUNING.cut_off_coordinates)
    return near


def in_picture(x: float, y: float, camera: CameraModel) -> bool:
    """Return whether a point of the plane is inside the image."""
    K = camera.K
    u, v = x * K[0, 0] + K[0, 2], y * K[1, 1] + K[1, 2]
    return bool(0.0 <= u < camera.width and 0.0 <= v < camera.height)
