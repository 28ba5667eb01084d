# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a track remembers, by numbers that anybody can check."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track


def _track(**changes):
    return Track("aqua", 0, 0, **changes)


def test_it_is_used_to_the_speed_at_which_it_swims():
    assert _track().typical_speed(0.75) == 0.75
    used = _track(speed_history=6.25, speed_history_count=0.5)
    assert used.typical_speed(0.75) == pytest.approx(np.sqrt((0.75**2 + 6.25) / 1.5))


def test_names_bring_their_habits_along():
    one = _track(robot_id="aqua_1", speed_history=2.0, speed_history_count=1.0)
    other = _track(robot_id="aqua_2", speed_history=8.0, speed_history_count=3.0)
    one.swap_labels(other)
    assert (one.robot_id, one.speed_history, one.speed_history_count) == ("aqua_2", 8.0, 3.0)
    assert (other.robot_id, other.speed_history, other.speed_history_count) == ("aqua_1", 2.0, 1.0)
    new = _track()
    new.inherit_label(one)
    assert (new.robot_id, new.speed_history, new.speed_history_count) == ("aqua_2", 8.0, 3.0)
    assert one.robot_id == "aqua_2"


def test_it_takes_in_what_another_track_of_the_same_robot_had():
    track = Track("aqua", 5, 9, hits=(5, 9), pending_boxes=((5, 1.0, 2.0),))
    other = Track("aqua", 3, 7, hits=(3, 7), pending_boxes=((3, 3.0, 4.0),))
    other.entered_view, other.label_pending = True, True
    track.absorb(other)
    assert (track.first_seen_ns, track.entered_view, track.label_pending) == (3, True, True)
    assert list(track.hits) == [3, 5, 7, 9]
    assert track.pending_boxes == ((5, 1.0, 2.0), (3, 3.0, 4.0))
    assert other.pending_boxes == ()
    later = Track("aqua", 4, 8, entered_view=False)
    track.absorb(later)
    assert (track.first_seen_ns, track.entered_view, track.label_pending) == (3, True, True)


def test_two_in_one_image_are_two_robots():
    one = _track(hits=(1, 2))
    assert one.coexisted(_track(hits=(2, 3)))
    assert not one.coexisted(_track(hits=(3,)))
