# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labels follow from the probabilities of robots and tracks in the likeliest order."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.identity.returns import decided


@pytest.mark.parametrize(
    ("law", "robots", "ended"),
    [
        ([[0.9, 0.1], [0.1, 0.9]], {5: 1, 6: 2}, set()),
        ([[0.6, 0.4], [0.4, 0.6]], {}, {1, 2}),  # nothing later can distinguish them
        ([[0.81, 0.19], [0.2, 0.8]], {5: 1}, {2}),
    ],
)
def test_a_track_gets_the_label_of_a_robot_that_is_likely_enough(law, robots, ended):
    done = decided([5, 6], [1, 2], np.array(law), {7})
    assert (done.robots, done.ended, done.waiting) == (robots, ended, {7})
    assert done.label_probabilities == {
        1: {5: law[0][0], 6: law[0][1]},
        2: {5: law[1][0], 6: law[1][1]},
    }
