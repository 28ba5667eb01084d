# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""No positions come from an image that is turned against its camera's pose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.rejection import Reason

ROBOTS = {"a": (0.0, 21.0), "b": (2.0, 16.0), "c": (-3.0, 18.0)}
TURNED_S, END_S = 12.0, 40.0


def test_boxes_of_a_turned_image_are_refused_until_it_is_turned_back(sea):
    """The drone flies to and fro past robots that stay; the driver is set right after 12 s."""
    world = sea.World(
        drone=lambda t: (abs((3.0 * t) % 40.0 - 20.0) - 10.0, 0.0, 25.0),
        rpy_deg=lambda _t: (0.0, 55.0, 90.0),
        robots={name: lambda _t, place=place: place for name, place in ROBOTS.items()},
        pixel_sigma=1.0,
    )
    frame = world.frame
    middle = np.array([1279.0, 719.0])

    def shown(t):
        found = frame(t)
        return replace(found, centers=middle - found.centers) if t < TURNED_S else found

    world.frame = shown
    engine = sea.estimator()
    results = sea.play(engine, world, END_S, images=10)
    seen = [one for one in results if one.boxes]
    refused = [one for one in seen if sea.stamp(8.0) < one.stamp_ns < sea.stamp(TURNED_S)]
    assert refused
    for one in refused:
        assert {box.reason for box in one.rejections} == {Reason.BAD_DETECTIONS}
        assert not one.estimates
    assert sum("as if it was turned by 180 deg" in words for words in engine.events) == 1
    last = [one for one in seen[-1].estimates if one.state is State.CONFIRMED]
    assert len(last) == len(ROBOTS)
    for one in last:
        apart = [np.linalg.norm(one.position - place) for place in ROBOTS.values()]
        assert min(apart) < 3.0 * one.sigma
