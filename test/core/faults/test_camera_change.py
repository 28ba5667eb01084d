# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Of two descriptions of a camera that one is used which boxes fit; without boxes the newest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.faults.camera_change import CameraChange
from aerial_gnss_ros.core.values.events import Events

SECOND = 1_000_000_000
K = np.array([[900.0, 0.0, 640.0], [0.0, 900.0, 360.0], [0.0, 0.0, 1.0]])
BEFORE = CameraModel(1280, 720, "plumb_bob", K)
AFTER = CameraModel(1280, 720, "plumb_bob", K * np.array([[1.3], [1.3], [1.0]]))


def images(given, worse, *, events=None):
    """Which description each of ten images a second uses, after one by the description before.

    Args:
        given: description of each image.
        worse: of each image, by how many nats its boxes fit worse by any other than `BEFORE`.
        events: log.
    """
    change = CameraChange(events or Events())
    change.update(BEFORE, 0, lambda _: 0.0)
    return [
        change.update(
            camera, (i + 1) * SECOND // 10, lambda one, add=add: add if one is AFTER else 5.0
        )
        for i, (camera, add) in enumerate(zip(given, worse, strict=True))
    ]


def test_a_description_that_boxes_contradict_waits_until_it_has_lasted():
    events = Events()
    used = images([AFTER] * 102, [15.0] * 102, events=events)
    assert used == [BEFORE] * 100 + [AFTER] * 2
    assert "has changed, but the boxes" in events.sentences[0]
    assert "for 10 s" in events.sentences[1]


def test_a_description_that_boxes_fit_is_used_at_once_and_for_good():
    # The zoom is described three images before it is seen.
    used = images([AFTER] * 10, [15.0] * 3 + [-15.0] * 2 + [15.0] * 5)
    assert used == [BEFORE] * 3 + [AFTER] * 7


def test_what_boxes_have_contradicted_is_not_used_when_robots_leave_the_view():
    assert images([AFTER] * 4, [15.0, 5.0, 5.0, 5.0]) == [BEFORE] * 4
    assert images([AFTER] * 4, [5.0, 5.0, 5.0, 15.0]) == [AFTER] * 3 + [BEFORE]


def test_the_same_description_sent_anew_is_no_change():
    again = replace(BEFORE, K=K.copy())
    used = images([AFTER, again, AFTER, AFTER], [15.0, 0.0, 5.0, 5.0])
    assert used == [BEFORE, again, AFTER, AFTER]  # nothing was left of what boxes said before
    for other in (replace(BEFORE, width=1281), replace(BEFORE, D=np.array([-0.6, 0.0, 0.0, 0.0]))):
        change = CameraChange(Events())
        change.update(BEFORE, 0, lambda _: 0.0)
        seen = []
        change.update(other, SECOND, lambda one, seen=seen: float(len(seen.append(one) or seen)))
        assert len(seen) == 2


@pytest.mark.parametrize(
    ("described", "shown", "kept"),
    [(1.3, 1.0, True), (1.3, 1.3, True), (0.8, 1.0, True), (1.0, 1.3, False)],
)
def test_robots_stay_where_they_are_whatever_changes_in_flight(sea, described, shown, kept):
    """A zoom, a description that alone changes, and a zoom that nobody describes (no box used)."""
    robots = {"a": (2.0, 21.0), "b": (-2.0, 16.0), "c": (3.0, 14.0)}
    world = sea.World(
        robots={name: lambda _t, place=place: place for name, place in robots.items()},
        pixel_sigma=1.0,
    )
    engine = sea.estimator({"noise.gnss_offset_m": 0.02})
    sea.play(engine, world, 4.0, until_flush=False)

    def zoomed(factor):
        return replace(sea.camera, K=sea.camera.K * np.array([[factor], [factor], [1.0]]))

    world.camera = zoomed(shown)
    results = sea.play(engine, world, 1.0, begin=4.1, camera=zoomed(described))
    confirmed = [one for one in results[-1].estimates if one.state.value == "confirmed"]
    places = {tuple(np.round(one.position).tolist()) for one in confirmed}
    assert (places == set(robots.values())) is kept
