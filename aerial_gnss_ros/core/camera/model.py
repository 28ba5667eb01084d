# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Camera models: pixel to ray and back, with Jacobians, as sensor_msgs/CameraInfo describes them.

Pixels are u to the right and v down, whole numbers at pixel centres (OpenCV, ROS). Rays and points
are in the optical frame: x right, y down, z forward.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerial_gnss_ros.core.camera.distortion import BrownConrady, Equidistant
from aerial_gnss_ros.core.camera.projection import plane_with_jacobian
from aerial_gnss_ros.core.camera.rays import fisheye_rays, pinhole_rays
from aerial_gnss_ros.core.camera.validation import (
    as_matrix,
    as_vector,
    check_size,
    check_view,
    check_whole_image,
    checked_coefficients,
    checked_matrix,
    checked_rotation,
    model_name,
)
from aerial_gnss_ros.core.numerics.columns import columns
from aerial_gnss_ros.core.numerics.small_arrays import MAX_ROWS
from aerial_gnss_ros.core.values.errors import CameraError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_BEHIND = 1e-9
_CIRCLE = np.array([(math.cos(a), math.sin(a)) for a in np.arange(0.0, 6.28, math.pi / 8)])


@dataclass(frozen=True, eq=False)
class CameraModel:
    """Intrinsics of one image size and zoom.

    Attributes:
        width: px.
        height: px.
        model: `plumb_bob`, `rational_polynomial` or `equidistant`.
        K: (3, 3) camera matrix, px.
        D: (n,) distortion coefficients in OpenCV's order; empty for none.
        rectified: whether the images are rectified already (K is then the left of P, D empty).
        R: (3, 3) rectified optical frame from the camera's own optical frame.

    Raises:
        CameraError: an unusable description, with the value seen.
    """

    width: int
    height: int
    model: str
    K: Array
    D: Array = field(default_factory=lambda: np.zeros(0))
    rectified: bool = False
    R: Array = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        given = {
            "K": checked_matrix(self.K, "K"),
            "D": checked_coefficients(self.model, self.D),
            "R": as_matrix(self.R, "R"),
        }
        for name, values in given.items():
            own = values.copy()
            own.setflags(write=False)
            object.__setattr__(self, name, own)
        check_size(self.width, self.height)
        check_view(self.K, self.width, self.height, self.model)
        if self.D.any():
            self._check_middle()

    def _check_middle(self) -> None:
        """Refuse a lens that folds over within half the distance to the image's nearer edges."""
        circle = 0.5 * self._size + 0.25 * self._size.min() * _CIRCLE
        if not self.rays(np.concatenate([0.5 * (circle + 0.5 * self._size), circle]))[1].all():
            raise CameraError(
                f"CameraInfo has distortion {self.D.tolist()}, with which the image folds over "
                "near its centre, as no lens does; calibrate the camera again."
            )

    @classmethod
    def from_camera_info(
        cls,
        width: int,
        height: int,
        distortion_model: str,
        d: ArrayLike,
        k: ArrayLike,
        r: ArrayLike | None = None,
        p: ArrayLike | None = None,
        rectified: bool = False,
        *,
        binning: tuple[int, int] = (0, 0),
        roi: tuple[int, int, int, int] = (0, 0, 0, 0),
    ) -> CameraModel:
        """Return the model of a sensor_msgs/CameraInfo's fields.

        Args:
            width: px.
            height: px.
            distortion_model: name; empty is allowed where `d` is empty or all zero.
            d: distortion coefficients.
            k: (9,) or (3, 3).
            r: (9,) or (3, 3) rectification; only used with `rectified`.
            p: (12,) or (3, 4) projection of the rectified image; only used with `rectified`.
            rectified: True when the images are rectified.
            binning: binning_x and binning_y; 0 and 1 both mean none.
            roi: x_offset, y_offset, width, height; zeros or the whole image mean none.

        Raises:
            CameraError: zeros (an uncalibrated camera), NaN, unknown model, wrong counts or sizes,
                binning or a region of interest.
        """
        check_size(width, height)
        check_whole_image(width, height, binning, roi)
        if not rectified:
            return cls(
                width, height, model_name(distortion_model, d), as_matrix(k, "K"), as_vector(d)
            )
        if p is None:
            raise CameraError("Images are rectified, but the CameraInfo gives no P.")
        projection = np.asarray(p, dtype=np.float64)
        if projection.size != 12:
            raise CameraError(f"CameraInfo has P with {projection.size} numbers instead of 12.")
        left = projection.reshape(3, 4)[:, :3]
        rotation = np.eye(3) if r is None else checked_rotation(as_matrix(r, "R"))
        return cls(
            width, height, "plumb_bob", checked_matrix(left, "P"), rectified=True, R=rotation
        )

    @classmethod
    def from_focal_length(
        cls,
        focal_length_m: float,
        sensor_width_m: float,
        sensor_height_m: float | None,
        width: int,
        height: int,
    ) -> CameraModel:
        """Return a pinhole camera without distortion, principal point at the image's middle.

        Args:
            focal_length_m: at the zoom used.
            sensor_width_m: the part of the sensor that the image's width covers.
            sensor_height_m: likewise for its height; None (or NaN) for square pixels.
            width: px.
            height: px.

        Raises:
            CameraError: a value that is not positive.
        """
        check_size(width, height)
        given = {"focal length": focal_length_m, "sensor width": sensor_width_m}
        no_height = sensor_height_m is None or math.isnan(sensor_height_m)
        if sensor_height_m is not None and not no_height:
            given["sensor height"] = sensor_height_m
        for name, value in given.items():
            if not (math.isfinite(value) and value > 0.0):
                raise CameraError(f"The {name} must be a positive length, not {value} m.")
        fx = focal_length_m * width / sensor_width_m
        fy = (
            fx
            if no_height or sensor_height_m is None
            else focal_length_m * height / sensor_height_m
        )
        K = np.array([[fx, 0.0, 0.5 * width], [0.0, fy, 0.5 * height], [0.0, 0.0, 1.0]])
        return cls(width, height, "plumb_bob", K)

    @cached_property
    def _lens(self) -> BrownConrady | Equidistant | None:
        if self.model == "equidistant":
            return Equidistant(self.D)
        if not self.D.any():
            return None
        return BrownConrady(np.concatenate([self.D, np.zeros(8 - self.D.size)]))

    @cached_property
    def _size(self) -> Array:
        """(2,) width and height, px."""
        return np.array([self.width, self.height], dtype=np.float64)

    @cached_property
    def _middle(self) -> Array:
        """(2,) the principal point, px."""
        return self.K[:2, 2].copy()

    @cached_property
    def _focal(self) -> Array:
        """(2, 2) pixels from the normalised plane."""
        return self.K[:2, :2].copy()

    @cached_property
    def _inverse(self) -> Array:
        """(2, 2) normalised plane from pixels."""
        return np.asarray(np.linalg.inv(self.K[:2, :2]), dtype=np.float64)

    @cached_property
    def _turned(self) -> bool:
        return not np.array_equal(self.R, np.eye(3))

    def inside(self, pixels: Array) -> Mask:
        """Return whether pixels (n, 2) lie on the image (to its outer edges), (n,)."""
        if len(pixels) <= MAX_ROWS:
            width, height = self._size.tolist()
            rows = pixels.tolist()
            return np.array([-0.5 <= u <= width and -0.5 <= v <= height for u, v in rows], np.bool_)
        within = (pixels >= -0.5) & (pixels <= self._size)
        on: Mask = within[:, 0] & within[:, 1]
        return on

    def rays(self, pixels: ArrayLike) -> tuple[Array, Mask]:
        """Return unit rays (n, 3) in the optical frame, and which are valid (n,).

        A pixel outside the image, or where the lens model folds over, is invalid; its ray is
        meaningless.
        """
        rays, _, valid = self.rays_with_jacobian(pixels)
        return rays, valid

    def rays_with_jacobian(self, pixels: ArrayLike) -> tuple[Array, Array, Mask]:
        """Return unit rays (n, 3), their derivative by the pixels (n, 3, 2), and validity (n,)."""
        given = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
        valid = self.inside(given)
        # Points outside the image are computed at its centre, so that nothing overflows.
        usable = given if all(valid.tolist()) else np.where(valid[:, None], given, self._middle)
        plane = (usable - self._middle) @ self._inverse.T
        lens = self._lens
        if isinstance(lens, Equidistant):
            rays, by_plane, on_lens = fisheye_rays(lens, plane)
        else:
            rays, by_plane, on_lens = pinhole_rays(lens, plane)
        jacobian: Array = by_plane @ self._inverse
        if self._turned:
            rays, jacobian = rays @ self.R, self.R.T @ jacobian
        return rays, jacobian, valid & on_lens

    def project(self, points: ArrayLike) -> tuple[Array, Mask]:
        """Return pixels (n, 2) of points (n, 3) in the optical frame, and which are valid (n,).

        A point behind the camera, beyond the lens model's fold or outside the image is invalid; in
        the last case its pixel is still right, otherwise NaN.
        """
        given = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        if self._turned:
            given = given @ self.R.T
        lens = self._lens
        if isinstance(lens, Equidistant):
            plane, seen = _fisheye_plane(lens, given)
        else:
            plane, seen = _pinhole_plane(lens, given)
        pixels = plane @ self._focal.T + self._middle
        pixels[~seen] = np.nan
        return pixels, seen & self.inside(pixels)

    def project_with_jacobian(self, points: ArrayLike) -> tuple[Array, Array, Mask]:
        """Return pixels (n, 2) of points (n, 3) as `project` does, and their derivative (n, 2, 3).

        The mask (n,) marks those in front of the lens and within its model, in the image or not.
        """
        given = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        given = given @ self.R.T if self._turned else given
        plane, by_point, seen = plane_with_jacobian(self._lens, given)
        matrix = self._focal
        by_point = matrix @ by_point @ self.R if self._turned else matrix @ by_point
        return plane @ matrix.T + self._middle, by_point, seen


def _pinhole_plane(lens: BrownConrady | None, points: Array) -> tuple[Array, Mask]:
    seen: Mask = points[:, 2] > _BEHIND
    plane = points[:, :2] / np.where(seen, points[:, 2], 1.0)[:, None]
    if lens is None:
        return plane, seen
    distorted, jacobian = lens.distort(plane)
    return distorted, seen & lens.monotonic(plane, jacobian)


def _fisheye_plane(lens: Equidistant, points: Array) -> tuple[Array, Mask]:
    x, y, z = columns(points)
    across = np.hypot(x, y)
    angle = np.arctan2(across, z)
    radius, _ = lens.radius(angle)
    scale = np.where(across > 0.0, radius / np.where(across > 0.0, across, 1.0), 0.0)
    seen: Mask = (angle < lens.max_angle) & np.any(points != 0.0, axis=1)
    return points[:, :2] * scale[:, None], seen
