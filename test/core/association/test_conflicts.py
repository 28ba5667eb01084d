# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which of two robots gets a box that may be of either."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.association.conflicts import keep_established, without_disputed
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.values.estimates import State


@pytest.mark.parametrize(
    ("beside", "away_ns", "wears"),
    [(False, 6, 0), (True, 6, 1), (True, 8, 0)],
    ids=["never beside", "beside", "away since"],
)
def test_a_box_stays_with_the_robot_that_wears_it(beside, away_ns, wears):
    """Unless images have shown both robots of late: then the better fit decides."""
    both = {5, 8} if beside else {8}
    tracks = [
        Track("aqua", 0, last, State.COASTING, f"aqua_{last}", tuple(sorted(hits)))
        for last, hits in ((9, {9, *both}), (7, {5, 7}))
    ]
    rows = keep_established(tracks, [0, 1], [0, 0], [1], [0, 1], away_ns)
    assert rows == [wears]


@pytest.mark.parametrize(
    ("gone_s", "off", "kept_by"),
    [
        ((1.0, 3.0), (2.0, 0.5), []),  # as likely the other one, out of sight for longer
        ((1.0, 3.0), (0.5, 5.0), [0]),
        ((0.2, 3.0), (2.0, 0.5), [0]),  # seen just now: its place is sure
        ((1.0, 1.5), (2.0, 0.5), [0]),  # both can be updated: the assignment has chosen
    ],
)
def test_a_box_that_may_be_of_a_robot_out_of_sight_for_longer_updates_nobody(gone_s, off, kept_by):
    """Robot 0 would get box 0; robot 1 is not updated by a single box after 2 s. Places to 1 m."""
    now = 100_000_000_000
    tracks = [
        Track("aqua", 0, now - round(gone * 1e9), State.COASTING, f"aqua_{i}", (1,))
        for i, gone in enumerate(gone_s)
    ]
    kind = ["robot" if gone <= 2.0 else "" for gone in gone_s]
    log = [-0.5 * one**2 for one in off]
    assert without_disputed(tracks, [0, 1], [0, 0], [0], log, kind, now) == kept_by
