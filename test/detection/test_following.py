# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes are searched for where they go, and given up when they stay away."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.detection.following import Follower
from aerial_gnss_ros.detection.pieces import Piece

SIZE, MARGIN = (640, 360), 20.0


def piece(u, v=100.0, half=10.0, cut=False, class_id=0):
    corners = np.array([u - half, v - half, u + half, v + half])
    return Piece(corners, 0.9, class_id, 0, np.array([cut, False, False, False]))


def shown(follower, *places, **more):
    """Show an image; return the middles of where boxes were searched for."""
    regions = follower.predict(SIZE)
    follower.update([piece(u, **more) for u in places])
    return ((regions[:, 0] + regions[:, 2]) / 2).tolist()


def test_a_box_is_searched_for_where_its_motion_leads():
    follower = Follower(MARGIN)
    for u in (100.0, 110.0, 120.0, 130.0):
        searched = shown(follower, u)
    assert searched == [130.0]
    assert shown(follower) == [140.0]  # it is missed
    assert shown(follower, 150.0) == [150.0]
    assert follower.followed[0].velocity.tolist() == [10.0, 0.0]


def test_a_new_box_is_given_the_motion_of_the_others():
    follower = Follower(MARGIN)
    shown(follower, 100.0, 300.0)
    shown(follower, 108.0, 308.0)
    shown(follower, 116.0, 316.0, 500.0)
    assert shown(follower) == [124.0, 324.0, 508.0]


def test_one_that_was_seen_often_is_searched_for_longer():
    gone = []
    for sightings in (1, 9):
        follower = Follower(MARGIN)
        for _ in range(sightings):
            shown(follower, 100.0)
        count = 0
        while follower.followed:
            shown(follower)
            count += 1
        gone.append(count)
    assert 0 < gone[0] < gone[1]


def test_what_leaves_the_image_is_dropped():
    follower = Follower(MARGIN)
    for u in (600.0, 620.0):
        shown(follower, u)
    assert shown(follower) == []
    assert follower.followed == []


def test_a_region_grows_while_a_box_is_missed_and_for_one_that_is_cut():
    def width(follower):
        (region,) = follower.predict(SIZE)
        return float(region[2] - region[0])

    whole, cut = Follower(MARGIN), Follower(MARGIN)
    for follower, is_cut in ((whole, False), (cut, True)):
        for _ in range(5):
            shown(follower, 100.0, cut=is_cut)
    seen = width(whole)
    assert seen == pytest.approx(20.0 + 2.0 * MARGIN)
    assert width(cut) == pytest.approx(seen + 2.0 * 20.0)
    whole.update([])
    assert width(whole) > seen
    assert whole.blind
    whole.forget()
    assert len(whole.predict(SIZE)) == 0


def test_the_nearest_box_continues_each_and_none_takes_two():
    follower = Follower(MARGIN)
    shown(follower, 100.0, 115.0)
    shown(follower, 108.0)
    assert [box.sightings for box in follower.followed] == [1, 2]
    assert [box.missed for box in follower.followed] == [1, 0]
