# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes tell how an image is turned or mirrored, from the way they go."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.faults.image_orientation import (
    TUNING,
    ImageOrientation,
    PosedBoxes,
    judged,
)

ROBOTS = {"a": lambda _t: (-3.0, 22.0), "b": lambda t: (0.3 * t, 15.0), "c": lambda _t: (6.0, 18.0)}
AS_SHOWN = {
    "as it is": lambda x, y: (x, y),
    "turned by 180 deg": lambda x, y: (-x, -y),
    "turned by 90 deg clockwise": lambda x, y: (-y, x),
    "turned by 90 deg counter-clockwise": lambda x, y: (y, -x),
    "mirrored left to right": lambda x, y: (-x, y),
    "mirrored top to bottom": lambda x, y: (x, -y),
}
"""Where a pixel (right, down from the middle) is in the image that is shown."""


def images(sea, drone, rpy_deg, shown=AS_SHOWN["as it is"], robots=ROBOTS):
    """Return ten seconds of posed images, 5 a second."""
    world = sea.World(drone=drone, rpy_deg=rpy_deg, robots=robots, pixel_sigma=2.0)
    middle = 0.5 * np.array([world.camera.width - 1.0, world.camera.height - 1.0])
    found = []
    for k in range(50):
        centers = world.frame(0.2 * k).centers - middle
        centers = middle + np.array([shown(x, y) for x, y in centers]).reshape(-1, 2)
        found.append(PosedBoxes(world.pose(0.2 * k), world.camera, centers))
    return found


def past(t):
    """A drone that flies east past the robots."""
    return -15.0 + 3.0 * t, 0.0, 25.0


def north(_t):
    """A camera that looks north and down."""
    return 0.0, 50.0, 90.0


@pytest.mark.parametrize("way", [*AS_SHOWN])
def test_a_flight_past_robots_tells_how_the_image_is_turned(sea, way):
    found = judged(images(sea, past, north, AS_SHOWN[way]))
    right, other = found.missed
    assert found.way == ("" if way == "as it is" else way)
    assert min(right, other) < 0.005
    assert max(right, other) > 0.01


@pytest.mark.parametrize("way", ["turned by 180 deg", "mirrored left to right"])
def test_a_camera_that_turns_on_the_spot_tells_it_as_well(sea, way):
    turning = images(sea, lambda _t: (0.0, 0.0, 25.0), lambda t: (0.0, 50.0, 70.0 + 4.0 * t),
                     AS_SHOWN[way])  # fmt: skip
    assert judged(turning).way == way


def test_from_an_orbit_around_robots_a_mirrored_image_is_told_and_a_turned_one_is_not(sea):
    def around(t):
        return 18.0 * np.sin(0.2 * t), 18.0 * (1.0 - np.cos(0.2 * t)), 20.0

    def inward(t):
        return 0.0, 48.0, 90.0 + np.degrees(0.2 * t)

    robots = {"a": lambda _t: (-4.0, 21.0)}
    found = {
        way: judged(images(sea, around, inward, shown, robots)).way
        for way, shown in AS_SHOWN.items()
    }
    assert found["as it is"] in ("", None)
    assert found["turned by 180 deg"] is None
    assert found["mirrored left to right"].startswith("mirrored")


@pytest.mark.parametrize(
    ("drone", "robots"),
    [(lambda _t: (0.0, 0.0, 25.0), ROBOTS), (past, {})],
    ids=["hovers", "sees nothing"],
)
def test_without_motion_or_boxes_nothing_is_told(sea, drone, robots):
    assert judged(images(sea, drone, north, robots=robots)).way is None


def test_it_takes_ten_pairs_and_half_a_minute_is_remembered(sea):
    turned = images(sea, past, north, AS_SHOWN["turned by 180 deg"])
    found = ImageOrientation()
    told = []
    for image in turned:
        found.update(image)
        told.append(found.way)
    first = next(k for k, way in enumerate(told) if way)
    pairs = TUNING.least_pairs
    assert turned[first].pose.stamp_ns - turned[0].pose.stamp_ns >= pairs * TUNING.least_s * 1e9
    found.update(turned[0])  # time was set back: no pair with what was later
    assert found.way == "turned by 180 deg"
    found.reset()
    assert found.way is None
