# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Results keep their order until they are taken, and each box is counted once."""

from __future__ import annotations

from dataclasses import replace

from aerial_gnss_ros.core.estimation.result_queue import ResultQueue
from aerial_gnss_ros.core.tracker.box_account import Settled
from aerial_gnss_ros.core.values.estimates import PlatformError
from aerial_gnss_ros.core.values.rejection import Cause, Reason, Rejection

GATED = Rejection(2, Reason.GATED, 1.0, 2.0)
FALSE = Rejection(1, Reason.UNCONFIRMED, 3.0, 4.0, Cause.CLUTTER)
LEFT = Rejection(2, Reason.UNCONFIRMED, 5.0, 6.0, Cause.CUT_SHORT)


def test_results_are_taken_once_in_their_order(result_at):
    queue = ResultQueue()
    first, second = result_at(1), result_at(2)
    queue.add(first)
    queue.add(second)
    assert queue.take() == [first, second]
    assert queue.take() == []


def test_each_box_is_counted_where_it_is_decided(result_at):
    """Seven boxes: four of robots, one gated, one false, one undecided until the end."""
    queue = ResultQueue()
    queue.add(result_at(1, boxes=3))  # all pending
    queue.add(
        replace(result_at(2, boxes=4), used=2, rejections=(GATED,), late=(FALSE,)),
    )
    queue.decide(Settled(1))
    assert (queue.boxes, queue.used) == (7, 3)
    assert queue.counts == {Reason.GATED: 1, Reason.UNCONFIRMED: 1}
    assert queue.causes == {Cause.CLUTTER: 1}
    queue.end(Settled(1, (LEFT,)))
    assert queue.ending == (LEFT,)
    assert queue.used == 4
    assert queue.counts == {Reason.GATED: 1, Reason.UNCONFIRMED: 2}
    assert queue.causes == {Cause.CLUTTER: 1, Cause.CUT_SHORT: 1}
    assert queue.boxes == queue.used + queue.counts.total()


def test_what_is_decided_belongs_to_the_last_result(result_at):
    queue = ResultQueue()
    first = replace(result_at(1), used=1)
    second = replace(result_at(2), used=2, late=(FALSE,))
    queue.add(first)
    queue.add(second)
    queue.decide(Settled(5, (LEFT,)))
    assert queue.take() == [first, replace(second, used=7, late=(FALSE, LEFT))]


def test_robots_are_those_of_the_last_result_and_errors_the_last_estimated(result_at):
    queue, heading = ResultQueue(), PlatformError("heading", 0.1, 0.02)
    queue.add(replace(result_at(1, ["a"]), platform=(heading,)))
    queue.add(result_at(2, ["a", "b"]))
    assert [one.robot_id for one in queue.robots] == ["a", "b"]
    assert queue.platform == (heading,)
    queue.forget_robots()
    assert (queue.robots, queue.platform) == ((), ())
    assert len(queue.take()) == 2


def test_a_complaint_is_made_of_its_own_counts(result_at):
    queue = ResultQueue()
    queue.add(replace(result_at(2, boxes=30), used=10, rejections=(GATED,) * 20))
    assert queue.complaint.startswith("20 of 30 boxes updated no robot, 20 as gated: ")
    queue.end(Settled(11))
    assert queue.complaint == ""
