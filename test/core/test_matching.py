# SPDX-License-Identifier: Apache-2.0
"""Which box of an image belongs to which track, where two tracks may be of one robot."""

from __future__ import annotations

from collections import deque

import numpy as np
import pytest

from aerial_gnss_ros.core.matching import kept
from aerial_gnss_ros.core.track import Track
from aerial_gnss_ros.core.values import State


@pytest.mark.parametrize(
    ("beside", "wears"), [(False, 0), (True, 1)], ids=["never beside", "beside"]
)
def test_a_box_stays_with_the_robot_that_wears_it(beside, wears):
    """Unless an image has shown both robots: then the better fit decides."""
    both = {5, 8} if beside else {8}
    tracks = [
        Track("aqua", 0, last, State.COASTING, f"aqua_{last}", deque(sorted(hits)))
        for last, hits in ((9, {9, *both}), (7, {5, 7}))
    ]
    rows = kept(tracks, np.array([1]), np.array([0]), np.ones((2, 1), dtype=bool))
    assert rows.tolist() == [wears]
