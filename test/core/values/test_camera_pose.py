# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where the camera is, and how errors of interpolation count that images share."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.values.camera_pose import CameraPose


@pytest.mark.parametrize(
    ("passed_s", "factors"),
    [
        (0.1, [10.0, 10.0, 5.0, 1.0, 1.0, 1.0]),
        (0.5, [2.0, 2.0, 1.0, 1.0, 1.0, 1.0]),  # of gaps shorter than that each image has its own
        (2.0, [1.0] * 6),
        (0.0, [1.0] * 6),
        (-1.0, [1.0] * 6),
    ],
)
def test_images_between_the_same_samples_count_for_one_together(passed_s, factors):
    variances = np.arange(1.0, 7.0)
    pose = CameraPose(
        0, 0.2, -1.0, 20.0, 20.0, np.eye(3), interpolation=variances,
        gaps_s=np.array([1.0, 1.0, 0.5, 0.05, 0.0, 0.05]),
    )  # fmt: skip
    assert pose.interpolation_noise(passed_s) == pytest.approx(variances * factors)


def test_without_interpolation_there_is_no_noise_of_it():
    assert not CameraPose(0, 0.2, -1.0, 20.0, 20.0, np.eye(3)).interpolation_noise(0.1).any()
