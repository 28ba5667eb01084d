# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where each unknown stands, and how much it counts."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.calibration.layout import Layout
from aerial_gnss_ros.calibration.pose_errors import ERRORS


def test_columns_follow_one_another_and_means_are_means() -> None:
    t = np.repeat(np.linspace(0.0, 12.0, 13), 2)
    sizes = np.tile([1.0, 2.0, 3.0], (26, 1))
    layout = Layout(t, np.tile([0, 1], 13), 1.0, dict.fromkeys(ERRORS, 2.0), sizes)
    assert layout.first_path[0] == layout.first_pointing + 3 * layout.pointing.count
    assert layout.first_box[0] == layout.first_path[1] + 2 * layout.paths[1].count
    assert layout.size == layout.first_box[1] + 2 * layout.boxes[1].count
    np.testing.assert_allclose(layout.pointing_weights[2].sum(axis=1), 3.0)
    pick = layout.mean_of("height")
    assert pick.sum() == pytest.approx(2.0)  # the constant, and the drift's mean
    assert np.count_nonzero(pick) > 2
