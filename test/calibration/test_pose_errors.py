# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The axes about which a camera's angles err."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.calibration.pose_errors import error_axes_of
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.gimbal import error_axes


def test_axes_of_many_cameras() -> None:
    turns = np.array([matrix_from_rpy(0.1, 0.7, 2.0), matrix_from_rpy(0.0, np.pi / 2, 0.3)])
    expected = [error_axes(one) for one in turns]
    np.testing.assert_allclose(error_axes_of(turns), expected)
