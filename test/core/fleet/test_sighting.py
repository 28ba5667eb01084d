# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A sighting holds what the drone's estimator measured, and the drone flies as without it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.simulation.feeding import feed
from aerial_gnss_ros.simulation.sensors import START_NS


def test_every_image_gives_a_sighting_with_the_boxes_of_confirmed_robots(two_rtk):
    of = {result.stamp_ns: result for result in two_rtk.alone["a"]}
    assert len(of) == len(two_rtk.sightings["a"])
    boxes = {b.stamp_ns: b for _, _, b in two_rtk.made["a"].detections()}
    for seen in two_rtk.sightings["a"]:
        result = of[seen.stamp_ns]
        confirmed = [e.robot_id for e in result.estimates if e.state is State.CONFIRMED]
        assert [label for label in seen.labels if label] == confirmed
        assert seen.pose == result.pose
        assert seen.class_ids == ("aqua",) * len(seen.labels)
        assert len(seen.pixels) == len(seen.doubt) == len(set(seen.tracks)) == len(seen.labels)
        for pixel, size, score in zip(seen.pixels, seen.sizes, seen.scores, strict=True):
            box = boxes[seen.stamp_ns]
            apart = np.abs(box.centers - pixel).sum(axis=1)
            assert apart.min() < 1e-6
            assert np.abs(box.sizes[apart.argmin()] - size).max() <= 0.05 + 1e-9
            assert abs(box.scores[apart.argmin()] - score) <= 0.0005 + 1e-9
        assert np.abs(seen.doubt).max(initial=0.0) < 1e-6
        assert not seen.jump.any()
        assert 1.0 <= seen.level < 2.0  # boxes are as noisy as stated


def test_boxes_before_confirmation_are_told_by_the_tracks_that_are_confirmed_later(two_rtk):
    first, *_ = [seen for seen in two_rtk.sightings["a"] if seen.labels]
    (confirmed,) = [s for s in two_rtk.sightings["a"] if "" not in s.labels and s.labels][:1]
    assert first.labels == ("", "", "")
    assert first.tracks == confirmed.tracks
    assert first.stamp_ns < confirmed.stamp_ns


def test_an_estimator_that_is_tapped_gives_the_same_results(two_rtk):
    one = two_rtk.made["a"]
    estimator = Estimator(two_rtk.configs["a"])
    feed(estimator, one.sensors)
    estimator.add_camera(START_NS - 10**9, one.camera)
    for _, _, boxes in one.detections():
        estimator.add_detections(boxes)
    plain = estimator.advance(START_NS + 10**12) + estimator.flush()
    for result, other in zip(plain, two_rtk.alone["a"], strict=True):
        for e, o in zip(result.estimates, other.estimates, strict=True):
            assert (e.robot_id, e.latitude, e.longitude) == (o.robot_id, o.latitude, o.longitude)


def test_a_jump_of_the_receiver_is_told(fleet_of):
    class Jumping:
        def __init__(self, estimator):
            self._estimator = estimator

        def __getattr__(self, name):
            return getattr(self._estimator, name)

        def add_fix(self, fix):
            if fix.stamp_ns > START_NS + 5 * 10**9:
                fix = replace(fix, latitude=fix.latitude + 40.0 / 6.37e6)
            self._estimator.add_fix(fix)

    flown = fleet_of(count=1, duration=12.0, seed=3, spoil=lambda _, one: Jumping(one))
    during = [s for s in flown.sightings["a"] if s.jump.any()]
    assert during
    assert all(abs(s.jump[1] - 40.0) < 2.0 and s.labels for s in during)
    last = flown.sightings["a"][-1]
    assert abs(last.believed[1] - 40.0) < 2.0
    assert last.labels
    assert last.doubt[0, 1, 1] > 20.0**2


def test_a_drone_that_begins_to_estimate_its_latency_still_tells_what_it_sees(fleet_of):
    """Its poses are then those of the latency that it has found."""
    late = {"camera.latency_s": 1.0, "camera.find_latency": True}
    flown = fleet_of(kind="orbit", count=1, noises=("rtk",), seed=3, duration=20.0, set_=late)
    seen = flown.sightings["a"]
    assert len(seen) > 95
    last = seen[-1]
    assert 1e-9 * abs(last.stamp_ns - last.pose.stamp_ns) < 0.05
    assert len([label for label in last.labels if label]) == 3
