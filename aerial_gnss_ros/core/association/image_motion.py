# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How the camera's motion moves all points of the picture alike from one image to the next.

Coordinates are those of the plane at distance 1 before the camera, so that lengths are angles (rad)
near the axis. The motion is an affine map of them:

    point + [1, 0, x, y, 0, 0; 0, 1, 0, 0, x, y] motion

Translations of the picture are turns of the camera and its way; what is linear is a turn about its
axis, a change of the distance, and how the water's distance differs over the picture.
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
    """By how much the rates of the camera's motion change from image to image, one sigma, 1/s:
    turns of 20 deg/s, or as large a share of the distance. Judged."""
    shear_share: float = 0.25
    """The same for what shears the picture or stretches it one way, as a share of RATE: that comes
    with a drone's acceleration, and slower. Judged."""
    cut_off_coordinates: float = 10.0
    """Coordinates of a box that is nowhere in the picture are cut off there. Judged."""


TUNING = ImageMotionTuning()


class Motion(NamedTuple):
    """How the camera moves points of the picture.

    Attributes:
        mean: (6,) see the module.
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
    """Return points (n, 2) after a motion of the camera."""
    after: Array = points + by_motion(points) @ motion.mean
    return after


def fitted(points: Array, after: Array, variances: Array, motion: Motion) -> Motion:
    """Return the camera's motion by points (n, 2) whose places (n, 2) in the next image are known.

    Args:
        points: where they were.
        after: where they are.
        variances: (n,) as for `links`.
        motion: of the camera, as it is expected.
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
    alike = 0.5 * (np.eye(4) + swap)  # turns and scales; the rest shears
    covariance[2:, 2:] = TUNING.rate_change_sigma**2 * (
        alike + TUNING.shear_share**2 * (np.eye(4) - alike)
    )
    return covariance


CHANGE = _change_of_rates()
"""… of which this is the covariance (6, 6), 1/s²."""


def on_plane(centers: Array, camera: CameraModel) -> Array:
    """Return pixels (n, 2) on the plane 1 before the camera, without regard to its distortion."""
    K = camera.K
    plane = (centers - K[:2, 2]) / np.array([K[0, 0], K[1, 1]])
    near: Array = np.clip(plane, -TUNING.cut_off_coordinates, TUNING.cut_off_coordinates)
    return near


def in_picture(x: float, y: float, camera: CameraModel) -> bool:
    """Return whether a point of the plane is in the picture."""
    K = camera.K
    u, v = x * K[0, 0] + K[0, 2], y * K[1, 1] + K[1, 2]
    return bool(0.0 <= u < camera.width and 0.0 <= v < camera.height)
