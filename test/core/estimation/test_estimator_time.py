# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The engine and time: waiting, latency, order, clocks that go backward, bounded memory."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerial_gnss_ros.core.estimation.image_queue import MAX_WAITING
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.rejection import Reason
from aerial_gnss_ros.core.values.samples import Scalar


def test_an_image_waits_for_late_telemetry_and_no_longer_than_max_wait(sea):
    scene = sea.Scene()
    scene.samples["height"] = (0.9,)
    scene.feed()
    assert scene.engine.advance(sea.stamp(1.1)) == []
    assert scene.engine.advance(sea.stamp(4.0)) == []
    scene.engine.add_height(scene.world.height(1.1))
    results = scene.engine.advance(sea.stamp(4.05))
    assert results[0].rejections == ()

    late = sea.Scene()
    late.samples["height"] = (0.9,)
    late.feed()
    assert late.engine.advance(sea.stamp(1.1)) == []
    assert [r.reason for r in late.engine.advance(sea.stamp(4.1))[0].rejections] == [
        Reason.STALE_HEIGHT
    ]


@pytest.mark.parametrize(("latency_s", "waited_s"), [(-1.2, 4.2), (0.0, 3.0), (1.2, 3.0)])
def test_a_latency_that_was_found_is_waited_for_like_a_configured_one(sea, latency_s, waited_s):
    scene = sea.Scene()
    scene.engine._tracks.pipeline.latency.scene_ns = round(latency_s * 1e9)
    scene.engine.add_detections(sea.boxes(0.0, [sea.middle]))
    assert scene.engine.advance(sea.stamp(0.0)) == []
    assert scene.engine.advance(sea.stamp(waited_s - 0.1)) == []
    assert len(scene.engine.advance(sea.stamp(waited_s + 0.1))) == 1


@pytest.mark.parametrize("latency", [-2.25, -0.5, 0.0, 0.4, 2.25])
def test_latency_of_both_signs(sea, latency):
    """The drone flies east at 5 m/s, so a latency that is not taken out shows as 5 m a second."""
    engine = sea.estimator({"camera.latency_s": latency, "tracks.confirm_hits": 1, "max_wait": 1.0})
    world = sea.World(drone=lambda t: (5.0 * t, 0.0, 30.0))
    engine.add_camera(sea.stamp(-5.0), sea.camera)
    # an image stamped 1 s shows the scene at 1 s - latency, where the robot was straight ahead
    results = []
    for i in range(-40, 90):
        t = 0.1 * i
        if i == 10:
            engine.add_detections(sea.boxes(1.0, [sea.middle]))
        for name in ("fix", "gimbal", "height"):
            getattr(engine, f"add_{name}")(getattr(world, name)(t))
        results += engine.advance(sea.stamp(t))
    assert [result.rejections for result in results] == [()]
    assert results[0].stamp_ns == sea.stamp(1.0)
    ahead = 5.0 * (1.0 - latency)
    assert results[0].estimates[0].position == pytest.approx([ahead, 17.3205], abs=2e-3)


def test_results_come_in_stamp_order_and_late_images_are_counted(sea):
    engine, world = sea.estimator(), sea.World()
    engine.add_camera(sea.stamp(0.0), sea.camera)
    for t in (0.4, 0.2, 0.3, 0.3):
        engine.add_detections(sea.boxes(t, [sea.middle]))
    for t in (0.0, 0.5):
        for name in ("fix", "gimbal", "height"):
            getattr(engine, f"add_{name}")(getattr(world, name)(t))
    results = engine.advance(sea.stamp(0.5))
    assert [r.stamp_ns for r in results] == [sea.stamp(t) for t in (0.2, 0.3, 0.4)]
    engine.add_detections(sea.boxes(0.35, [sea.middle]))
    engine.add_detections(sea.boxes(0.4, [sea.middle]))
    assert engine.advance(sea.stamp(0.6)) == []
    assert engine.dropped == {"duplicate": 2, "out_of_order": 1}


@pytest.mark.parametrize("source", ["fix", "gimbal", "detections", "clock"])
def test_time_that_goes_backward_clears_and_says_so_once(sea, source):
    engine = sea.estimator()
    world = sea.World(robots={"a": lambda _t: (3.0, 22.0)})
    first = sea.play(engine, world, 3.0, begin=100.0, until_flush=False)
    assert first[-1].estimates[0].robot_id == "aqua_1"
    engine.take_events()
    if source == "detections":
        engine.add_detections(sea.boxes(0.0, []))
    elif source == "clock":
        engine.advance(sea.stamp(0.0))
    else:
        getattr(engine, f"add_{source}")(getattr(world, source)(0.0))
    again = sea.play(engine, world, 2.0, begin=0.1)
    reported = engine.take_events()
    assert len(reported) == 1
    assert "Time went backward by 10" in reported[0]
    assert source in reported[0]
    assert [e.robot_id for e in again[-1].estimates] == ["aqua_2"]  # no name is used twice
    stamps = [result.stamp_ns for result in again]
    assert stamps == sorted(stamps)


def test_after_a_jump_only_camera_and_level_hold_on(sea):
    """They may not be sent again; a fix of the former time must not serve the new one."""
    engine, world = sea.estimator(), sea.World()
    engine.add_water_level(Scalar(sea.stamp(100.0), 2.0))
    sea.play(engine, world, 10.0, begin=100.0, until_flush=False)
    engine.advance(sea.stamp(105.0))
    engine.add_detections(sea.boxes(105.05, [sea.middle]))
    assert [r.reason for r in engine.flush()[0].rejections] == [Reason.NO_FIX]
    for t in (105.1, 105.2):
        for name in ("fix", "gimbal", "height"):
            getattr(engine, f"add_{name}")(getattr(world, name)(t))
    engine.add_detections(sea.boxes(105.15, [sea.middle]))
    result = engine.advance(sea.stamp(105.2))[0]
    assert result.rejections == ()
    assert result.pose.height == pytest.approx(28.0)


def test_stamps_of_another_clock_are_reported(sea):
    """A bag in a loop: headers begin again, what is stamped on arrival goes on."""
    engine, world = sea.estimator(), sea.World()
    sea.play(engine, world, 2.0, begin=10.0, until_flush=False)
    for i in range(10):
        t = 5.0 + 0.1 * i
        engine.add_detections(sea.boxes(t, [sea.middle]))
        engine.add_fix(world.fix(t))
        engine.add_gimbal(world.gimbal(t))
        engine.add_height(Scalar(sea.stamp(t + 20.0), 30.0))
    reasons = {r.reason for result in engine.flush() for r in result.rejections}
    assert reasons == {Reason.NO_HEIGHT}
    assert engine.happened["time_went_backward"] == 1
    reported = [sentence for sentence in engine.events if "their clocks differ" in sentence]
    assert len(reported) == 1
    assert "The oldest height is 20.0 s later than an image" in reported[0]


def test_a_frame_of_500_false_boxes_is_reported_and_makes_no_robot(sea):
    engine, world = sea.estimator(), sea.World(robots={"a": lambda _t: (3.0, 22.0)})
    sea.play(engine, world, 3.0, until_flush=False)
    centers = np.random.default_rng(1).uniform((0.0, 0.0), (1280.0, 720.0), (500, 2))
    engine.add_detections(sea.boxes(3.05, centers))
    sea.play(engine, world, 3.0, begin=3.1)
    assert [robot.robot_id for robot in engine.robots] == ["aqua_1"]
    assert engine.happened == {"images_crowded": 1}
    assert sum("An image has 500 boxes" in sentence for sentence in engine.events) == 1


def test_a_bound_name_is_bound_anew_after_a_jump(sea):
    place = [math.degrees(a[0]) for a in sea.World().local.places(np.array([[3.0, 22.0]]))]
    engine = sea.estimator({"robots": {"leader": {"class": "aqua", "start": place}}})
    world = sea.World(robots={"a": lambda _t: (3.0, 22.0)})
    for begin in (100.0, 0.0):
        last = sea.play(engine, world, 2.0, begin=begin)[-1]
        assert [e.robot_id for e in last.estimates] == ["leader"]


def test_a_sample_a_little_out_of_order_is_no_backward_clock(sea):
    engine, world = sea.estimator(), sea.World()
    engine.add_fix(world.fix(2.0))
    engine.add_fix(world.fix(0.5))
    assert not any("backward" in sentence for sentence in engine.events)
    engine.add_fix(world.fix(2.0))
    engine.add_fix(world.fix(2.1))
    assert engine.inputs["fix"].unordered == 2  # a late one, and a second one with its stamp


def test_the_newest_camera_not_later_than_the_image_is_used(sea):
    """Zoom: twice the focal length from 1 s on; the same pixel lies nearer to the axis."""
    scene = sea.Scene({"tracks.confirm_hits": 1})
    K = sea.camera.K.copy()
    K[0, 0] = K[1, 1] = 1800.0
    zoomed = type(sea.camera)(1280, 720, "plumb_bob", K)
    nearer = K.copy()
    nearer[0, 0] = nearer[1, 1] = 7200.0
    later = type(sea.camera)(1280, 720, "plumb_bob", nearer)
    scene.engine.add_camera(sea.stamp(0.99), zoomed)
    scene.engine.add_camera(sea.stamp(1.01), later)
    scene.boxes = sea.boxes(1.0, [[740.0, 360.0]])
    east = scene.run().estimates[0].position[0]
    assert east == pytest.approx(100.0 / 1800.0 * 30.0 / math.sin(math.radians(60)), abs=1e-3)


def test_a_refused_image_still_gives_the_coasting_robots(sea):
    engine, world = sea.estimator(), sea.World(robots={"a": lambda _t: (3.0, 22.0)})
    sea.play(engine, world, 2.0, until_flush=False)
    engine.add_detections(world.frame(3.0))
    result = engine.flush()[0]
    assert [r.reason for r in result.rejections] == [Reason.STALE_FIX]
    assert [(e.robot_id, e.state) for e in result.estimates] == [("aqua_1", State.COASTING)]
    assert result.pose is None


def test_flush_leaves_nothing_behind_and_memory_is_bounded(sea):
    engine = sea.estimator()
    for i in range(MAX_WAITING + 5):
        engine.add_detections(sea.boxes(0.01 * i, [sea.middle]))
    assert len(engine.advance(sea.stamp(0.0))) == 5
    assert len(engine.flush()) == MAX_WAITING
    assert engine.flush() == []
    for i in range(20_000):
        engine.add_height(Scalar(sea.stamp(0.01 * i), 30.0))
    assert len(engine._inputs._buffers["height"].series) < 6_100  # a minute's worth


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.sampled_from("fghcdnl"), st.integers(0, 80)), max_size=60))
def test_any_order_of_arrival_gives_each_image_one_result(sea, messages):
    """No exception, whatever comes; every image is answered once or counted as dropped."""
    engine, world = sea.estimator(), sea.World(robots={"a": lambda _t: (3.0, 22.0)})
    answered, images = [], 0
    for kind, tenth in messages:
        t = 0.1 * tenth
        if kind == "f":
            engine.add_fix(world.fix(t))
        elif kind == "g":
            engine.add_gimbal(world.gimbal(t))
        elif kind == "h":
            engine.add_height(world.height(t))
        elif kind == "l":
            engine.add_water_level(Scalar(sea.stamp(t), 0.1))
        elif kind == "c":
            engine.add_camera(sea.stamp(t), sea.camera)
        elif kind == "d":
            engine.add_detections(world.frame(t))
            images += 1
        else:
            answered += engine.advance(sea.stamp(t))
    answered += engine.flush()
    assert len(answered) + sum(engine.dropped.values()) == images
    assert all(np.isfinite(e.covariance).all() for r in answered for e in r.estimates)
