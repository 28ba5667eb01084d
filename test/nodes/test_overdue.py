# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""When positions are predicted for want of images."""

from __future__ import annotations

from aerial_gnss_ros.nodes.overdue import Overdue

S = 1_000_000_000


def due(overdue, *seconds):
    return [overdue.due(round(second * S)) for second in seconds]


def test_from_two_seconds_on_once_a_second_by_the_images_clock():
    overdue = Overdue()
    assert due(overdue, 0.0, 100.0) == [None, None]
    overdue.processed(7000 * S, 100 * S)  # the camera's clock is another one
    assert due(overdue, 101.0, 101.99) == [None, None]
    assert due(overdue, 102.0, 102.1, 102.9) == [7002 * S, None, None]
    assert due(overdue, 103.05, 103.9, 104.0) == [7003 * S + S // 20, None, 7004 * S]
    assert overdue.seconds(round(104.5 * S)) == 4.5
    overdue.processed(7005 * S, 105 * S)
    assert overdue.seconds(106 * S) == 0.0
    assert due(overdue, 106.9, 107.0) == [None, 7007 * S]


def test_what_was_missed_comes_once():
    overdue = Overdue()
    overdue.processed(0, 0)
    assert due(overdue, 9.5, 9.6, 10.0) == [9 * S + S // 2, None, 10 * S]


def test_while_simulated_time_stands_still_nothing_is_due():
    overdue = Overdue()
    overdue.processed(50 * S, 50 * S)
    assert due(overdue, *[51.9] * 100) == [None] * 100


def test_a_clock_that_goes_backward_is_waited_for():
    overdue = Overdue()
    overdue.processed(50 * S, 50 * S)
    assert due(overdue, 10.0, 11.9, 12.0) == [None, None, 52 * S]
