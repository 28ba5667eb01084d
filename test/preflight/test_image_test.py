# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The words about an image that is turned or mirrored."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.faults.image_orientation import PosedBoxes
from aerial_gnss_ros.preflight.image_test import image_test
from aerial_gnss_ros.preflight.verdict import Verdict


def images(sea, turn, speed=3.0, shown=True):
    """Return ten seconds of a flight east past a robot; `turn` is -1 where the image is turned."""
    world = sea.World(
        drone=lambda t: (speed * (t - 5.0), 0.0, 25.0),
        rpy_deg=lambda _t: (0.0, 50.0, 90.0),
        robots={"a": lambda _t: (0.0, 22.0)} if shown else {},
    )
    middle = 0.5 * np.array([world.camera.width - 1.0, world.camera.height - 1.0])
    for k in range(50):
        centers = middle + turn * (world.frame(0.2 * k).centers - middle)
        yield PosedBoxes(world.pose(0.2 * k), world.camera, centers)


@pytest.mark.parametrize(
    ("given", "verdict", "words"),
    [
        ({"turn": 1}, Verdict.PASS, "boxes are 0.0% of the image's width from where they should"),
        ({"turn": -1}, Verdict.FAIL, "0.0% if the image is turned by 180 deg: turn it back in"),
        ({"turn": 1, "speed": 0.0}, Verdict.NOT_TESTED, "boxes hardly moved through the image"),
        ({"turn": 1, "shown": False}, Verdict.NOT_TESTED, "boxes and the camera's pose hardly"),
    ],
    ids=["right", "turned", "hovers", "sees nothing"],
)
def test_the_verdict_and_what_was_seen(sea, given, verdict, words):
    found = image_test([*images(sea, **given)], 1.5)
    assert found.verdict is verdict
    assert words in found.seen


def test_what_robots_may_do_is_left_to_the_operator(sea):
    found = image_test([*images(sea, -1)], 20.0)
    assert found.verdict is Verdict.LOOK
    assert "; right as it is if what floats moved at " in found.seen
