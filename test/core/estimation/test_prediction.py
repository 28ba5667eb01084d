# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Positions between images and after the last one: predicted on a copy, the filter undisturbed."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.values.estimates import State


def swimming(sea):
    """Two robots, one of them under way to the east at 0.5 m/s."""
    return sea.World(
        robots={"a": lambda t: (-4.0 + 0.5 * t, 17.0), "b": lambda _t: (4.0, 19.0)}, pixel_sigma=1.0
    )


def test_robots_go_on_and_grow_uncertain(sea):
    engine = sea.estimator()
    last = sea.play(engine, swimming(sea), 5.0)[-1]
    soon, late = (engine.predicted(sea.stamp(5.0 + ahead)) for ahead in (2.0, 30.0))
    assert [one.robot_id for one in late.estimates] == ["aqua_1", "aqua_2"]
    assert {one.state for one in (*soon.estimates, *late.estimates)} == {State.COASTING}
    assert {one.state for one in last.estimates} == {State.CONFIRMED}
    assert (soon.stamp_ns, late.stamp_ns) == (sea.stamp(7.0), sea.stamp(35.0))
    assert {one.stamp_ns for one in late.estimates} == {late.stamp_ns}
    assert late.datum == last.datum
    for now, then, last_one in zip(soon.estimates, late.estimates, last.estimates, strict=True):
        sizes = [np.linalg.det(one.covariance[:2, :2]) for one in (last_one, now, then)]
        assert sizes[0] < sizes[1] < sizes[2]
        moved = now.position - last_one.position
        assert moved == pytest.approx(2.0 * last_one.velocity, rel=0.1, abs=0.02)
        assert now.last_seen_ns == last_one.last_seen_ns


def test_the_filter_does_not_notice(sea):
    def flown(*asked):
        results, engine, world = [], sea.estimator(), swimming(sea)
        for begin in (0.0, 6.0):
            results += sea.play(engine, world, 3.0, begin=begin)
            for ahead in asked:
                engine.predicted(sea.stamp(begin + 3.0 + ahead))
        return results

    asked, left_alone = flown(1.0, 2.0, 500.0), flown()
    for one, other in zip(asked, left_alone, strict=True):
        assert one.stamp_ns == other.stamp_ns
        for a, b in zip(one.estimates, other.estimates, strict=True):
            assert (a.robot_id, a.state) == (b.robot_id, b.state)
            assert np.array_equal(a.position, b.position)
            assert np.array_equal(a.covariance, b.covariance)


def test_who_would_be_lost_by_then_is_left_out_and_still_comes_back(sea):
    engine = sea.estimator({"tracks.coast_s": 20.0})
    sea.play(engine, swimming(sea), 3.0)
    assert len(engine.predicted(sea.stamp(22.9)).estimates) == 2
    assert engine.predicted(sea.stamp(23.2)).estimates == ()
    back = sea.play(engine, swimming(sea), 3.0, begin=6.0)[-1]
    assert [one.robot_id for one in back.estimates] == ["aqua_1", "aqua_2"]


def test_there_is_no_prediction_before_the_first_image_nor_into_the_past(sea):
    engine = sea.estimator()
    assert engine.predicted(sea.stamp(1.0)) is None
    sea.play(engine, swimming(sea), 2.0)
    assert engine.predicted(sea.stamp(2.0)) is None
    assert engine.predicted(sea.stamp(2.0) + 1) is not None


def test_stamps_stay_in_order_where_an_image_waits_for_its_telemetry(sea):
    engine, world = sea.estimator(), swimming(sea)
    sea.play(engine, world, 2.0)
    engine.add_detections(world.frame(2.1))
    assert engine.advance(sea.stamp(2.2)) == []
    assert engine.predicted(sea.stamp(4.5)).stamp_ns == sea.stamp(2.1) - 1
