# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Candidates of references: tracks of the class in view, and where the box is expected."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.references.candidates import (
    Expected,
    below_camera,
    candidates_of,
    with_crowding,
)
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.reference_place import ReferencePlace


def track(sea, label, class_id="buoy", seen=1.0):
    return Track(class_id, 0, sea.stamp(seen), State.CONFIRMED, label)


def expected(sea, *references):
    """Return where they appear 30 m above the map's origin."""
    world = sea.World()
    return [Expected.of(one, world.pose(1.0), world.local) for one in references]


def place(local, name, at, **more):
    latitude, longitude = local.places(np.array([at]))
    return ReferencePlace(name, "buoy", latitude[0], longitude[0], 0.01 * np.eye(2), **more)


def test_of_its_class_and_in_view_or_the_reference_already(sea):
    local = sea.World().local
    one = expected(sea, place(local, "mark", (4.0, 18.0)))
    tracks = [
        track(sea, "buoy_1"),
        track(sea, "aqua_1", "aqua"),
        track(sea, ""),
        track(sea, "buoy_2", seen=0.5),
        track(sea, "buoy_3", seen=0.5),
    ]
    assert [c.rows for c in candidates_of(one, sea.stamp(1.0), tracks, {})] == [(0,)]
    assert [c.rows for c in candidates_of(one, sea.stamp(1.0), tracks, {"mark": "buoy_3"})] == [
        (0, 4)
    ]


@pytest.mark.parametrize(("high", "factor"), [(0.0, 1.0), (2.0, 30.0 / 28.0)])
def test_what_stands_out_of_the_water_appears_farther_off(sea, high, factor):
    """Similar triangles: 2 m high, 30 m below the camera: 30/28 of the distance."""
    local = sea.World().local
    (found,) = expected(sea, place(local, "mark", (4.0, 18.0), height=high))
    assert found.position == pytest.approx(factor * np.array([4.0, 18.0]), abs=2e-3)


def test_one_above_the_camera_is_refused_once_in_a_sentence(sea):
    world, log = sea.World(), Events()
    both = [
        place(world.local, "mast", (4.0, 18.0), height=30.0),
        place(world.local, "pier", (1, 9)),
    ]
    for _ in range(2):
        assert below_camera(both, world.pose(1.0), log) == both[1:]
    (sentence,) = log.sentences
    assert "references.mast.height_m is 30 m" in sentence
    assert "30.0 m above the water" in sentence


def test_more_tracks_than_references_of_a_class_are_a_crowd(sea):
    local = sea.World().local
    moving = place(local, "rtk", (9.0, 9.0), moves=True)
    one = expected(sea, place(local, "mark", (4.0, 18.0)), moving)
    for count, crowded in ((2, False), (3, True)):
        tracks = [track(sea, f"buoy_{i}") for i in range(count)]
        found = with_crowding(candidates_of(one, sea.stamp(1.0), tracks, {}), one)
        assert {name: c.crowded for name, c in found.items()} == {"mark": crowded, "rtk": crowded}
        assert {name: c.stays for name, c in found.items()} == {"mark": True, "rtk": False}
