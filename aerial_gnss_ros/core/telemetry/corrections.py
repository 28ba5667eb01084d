# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Applies constant corrections of angles and focal length: true = measured + correction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.gimbal import error_axes
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix

Array = NDArray[np.float64]


def corrected_camera(measured: Array, turn: Array) -> Array:
    """Return a camera's orientation with corrections to its angles.

    Args:
        measured: (3, 3) camera FLU in ENU.
        turn: (3,) about the axes of `gimbal.error_axes`: roll, pitch, heading, rad.
    """
    turned: Array = rotation_matrix(error_axes(measured) @ turn) @ measured
    return turned


def scaled_camera(camera: CameraModel, scale: float) -> CameraModel:
    """Return a camera with its focal length multiplied by a factor."""
    K = camera.K.copy()
    K[:2, :2] *= scale
    return replace(camera, K=K)
