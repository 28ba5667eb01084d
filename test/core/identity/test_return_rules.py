# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""When a track that may be several robots waits, and when it gets a label."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.identity.return_rules import sure, undecided, unsettled

ONE = np.array([0])


@pytest.mark.parametrize(
    ("likely", "age", "gone", "waits"),
    [
        ((0.6, 0.3), 0.3, np.nan, True),  # until its velocity is known
        ((0.6, 0.3), 1.1, np.nan, False),  # the camera left them: nobody will surface
        ((0.6, 0.3), 1.1, 20.0, True),  # the other one may surface
        ((0.6, 0.3), 4.9, 20.0, True),  # 4 s, and 5 % of the 20 s that it was unseen
        ((0.6, 0.3), 5.1, 20.0, False),  # not any more
        ((0.6, 0.01), 1.1, 20.0, False),  # there is no other one
        ((0.97, 0.02), 0.1, 20.0, False),
    ],
)
def test_who_waits(likely, age, gone, waits):
    found = undecided(
        np.array(likely)[:, None], np.array([age]), np.array([True]), np.array([20.0, 20.0]),
        np.full((2, 1), gone),
    )  # fmt: skip
    assert found.tolist() == [waits]


def test_those_that_surfaced_together_wait_for_their_velocities():
    law = np.array([[0.7, 0.3], [0.3, 0.7]])
    for age, waits in ((0.2, True), (1.2, False)):
        assert unsettled(law, np.arange(2), np.full(2, age)).tolist() == [waits] * 2


@pytest.mark.parametrize(
    ("likely", "named", "settled", "found"),
    [
        (0.85, False, False, True),
        (0.85, True, False, False),  # it is published, and can wait until it is clear
        (0.96, True, False, True),
        (0.85, True, True, True),
        (0.5, True, True, False),  # it may as well be a new one
        (0.5, False, True, True),
    ],
)
def test_how_sure_is_enough(likely, named, settled, found):
    assert sure(np.array([[likely]]), ONE, ONE, np.array([named]), settled).tolist() == [found]
