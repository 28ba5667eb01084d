# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Validation of camera descriptions: each possible error of a CameraInfo is one sentence."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerial_gnss_ros.core.values.errors import CameraError

Array = NDArray[np.float64]

LARGEST_COEFFICIENT = 1e6
"""Greatest plausible distortion coefficient; rational models fitted to too little data reach some
thousands."""

WIDEST_DEG = {"plumb_bob": 170.0, "rational_polynomial": 170.0, "equidistant": 360.0}
"""Field of view that no lens of a model exceeds. A lens that keeps lines straight has cos⁴(85 deg),
a seventeen-thousandth, of its light at the edges of 170 deg, and the widest that are made see 130
deg; with barrel distortion a lens sees more than K says. A fisheye's picture is a circle that may
be smaller than the image: only the middle half must show less than there is."""

MODELS = tuple(WIDEST_DEG)


def check_size(width: int, height: int) -> None:
    """Refuse an image without pixels."""
    if width <= 0 or height <= 0:
        raise CameraError(
            f"CameraInfo gives an image of {width} x {height} px; the camera is not configured. "
            "Calibrate it, or give focal length and sensor size as parameters."
        )


def check_whole_image(
    width: int, height: int, binning: tuple[int, int], roi: tuple[int, int, int, int]
) -> None:
    """Refuse binning and regions of interest: K would not be the image's."""
    if any(factor not in (0, 1) for factor in binning):
        raise CameraError(
            f"CameraInfo has binning {binning[0]} x {binning[1]}, which is not supported; publish "
            "a CameraInfo of the image as it is sent."
        )
    if any(roi) and tuple(roi) != (0, 0, width, height):
        raise CameraError(
            f"CameraInfo has a region of interest ({roi[2]} x {roi[3]} px at {roi[0]}, {roi[1]}), "
            "which is not supported; publish a CameraInfo of the image as it is sent."
        )


def as_vector(values: ArrayLike) -> Array:
    """Return numbers as (n,)."""
    return np.asarray(values, dtype=np.float64).reshape(-1)


def as_matrix(values: ArrayLike, name: str) -> Array:
    """Return nine numbers as (3, 3)."""
    matrix = np.asarray(values, dtype=np.float64)
    if matrix.size != 9:
        raise CameraError(f"CameraInfo has {name} with {matrix.size} numbers instead of 9.")
    return matrix.reshape(3, 3)


def model_name(model: str, d: ArrayLike) -> str:
    """Return the distortion model's name; empty means none, where the coefficients agree."""
    if model:
        return model
    if np.any(as_vector(d) != 0.0):
        raise CameraError(
            "CameraInfo has distortion coefficients but no distortion_model; it must be one of "
            f"{', '.join(MODELS)}."
        )
    return "plumb_bob"


def checked_matrix(matrix: ArrayLike, name: str) -> Array:
    """Return a valid camera matrix (3, 3)."""
    K = np.asarray(matrix, dtype=np.float64)
    if K.shape != (3, 3):
        raise CameraError(f"The camera matrix {name} must be 3 x 3, not {K.shape}.")
    if not K.any():
        raise CameraError(
            f"CameraInfo has {name} of zeros: the camera is not calibrated. Calibrate it, or give "
            "focal length and sensor size as parameters."
        )
    ok = np.isfinite(K).all() and K[0, 0] > 0.0 and K[1, 1] > 0.0 and K[1, 0] == 0.0
    if not ok or not np.array_equal(K[2], [0.0, 0.0, 1.0]):
        raise CameraError(
            f"CameraInfo has an impossible {name}: {np.round(K, 6).tolist()}; it must be "
            "[[fx, s, cx], [0, fy, cy], [0, 0, 1]] with fx and fy above 0."
        )
    return K


def check_view(K: Array, width: int, height: int, model: str) -> None:
    """Refuse a valid camera matrix (3, 3) that does not belong to an image of this size.

    Lenses stand in front of the middle of their sensors, so the principal point of a whole image
    is near its middle. A region of interest moves it, but leaves it in the image: one beside the
    optical axis would look where the camera does not point.
    """
    for name, middle, side in (("cx", K[0, 2], width), ("cy", K[1, 2], height)):
        if not 0.0 < middle < side:
            raise CameraError(
                f"The camera's principal point is not in its image: {name} is {middle:g} px, and "
                f"the image has {width} x {height} px; calibrate it in pixels of the image as it "
                "is sent."
            )
    for name, focal, middle, side in (
        ("fx", K[0, 0], K[0, 2], width),
        ("fy", K[1, 1], K[1, 2], height),
    ):
        if model == "equidistant":
            part, across = "the middle half", 0.5 * min(width, height) / focal
        else:
            part, across = "it", math.atan(middle / focal) + math.atan((side - middle) / focal)
        if math.degrees(across) > WIDEST_DEG[model]:
            raise CameraError(
                f"The camera's image has {width} x {height} px and {name} is {focal:g} px, so "
                f"{part} would show {math.degrees(across):.1f} deg, where no {model} lens shows "
                f"more than {WIDEST_DEG[model]:g} deg; calibrate it in pixels of the image as it "
                "is sent."
            )


def checked_rotation(matrix: Array) -> Array:
    """Return a rectification (3, 3) that is a rotation."""
    if not np.allclose(matrix @ matrix.T, np.eye(3), atol=1e-4) or np.linalg.det(matrix) < 0.0:
        raise CameraError(
            f"CameraInfo has R that is not a rotation: {np.round(matrix, 6).tolist()}; images said "
            "to be rectified need one (the identity for a single camera)."
        )
    return matrix


def checked_coefficients(model: str, d: Sequence[float] | Array) -> Array:
    """Return distortion coefficients (n,) whose number fits the model."""
    coefficients = as_vector(d)
    if model not in MODELS:
        raise CameraError(
            f"CameraInfo has distortion model '{model}', which is not known; it must be one of "
            f"{', '.join(MODELS)}."
        )
    if not np.isfinite(coefficients).all():
        raise CameraError(f"CameraInfo has distortion {coefficients.tolist()}, not all finite.")
    if np.abs(coefficients).max(initial=0.0) > LARGEST_COEFFICIENT:
        raise CameraError(
            f"CameraInfo has distortion {coefficients.tolist()}: no lens has coefficients above "
            f"{LARGEST_COEFFICIENT:g}; calibrate the camera again."
        )
    count = coefficients.size
    allowed = {
        "plumb_bob": count <= 5,
        "rational_polynomial": count in (0, 8),
        "equidistant": count == 4,
    }
    if not allowed[model]:
        wanted = {"plumb_bob": "5 or fewer", "rational_polynomial": "8", "equidistant": "4"}[model]
        raise CameraError(f"CameraInfo has {count} distortion coefficients; {model} has {wanted}.")
    return coefficients
