# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A drone keeps a minute of its sightings; the oldest is given up first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.fleet.outbox import TUNING, Outbox
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.values.camera_pose import CameraPose

SECOND_NS = 10**9
CAMERA = CameraModel.from_focal_length(0.01, 0.01, None, 640, 480)
NOTHING = Sighting(
    0, "camera", CAMERA, CameraPose(0, 0.2, 0.3, 10.0, 10.0, np.eye(3)), np.zeros(3), np.zeros(2),
    (), (), (), np.zeros((0, 2)), np.zeros((0, 2, 2)),
)  # fmt: skip


def at(seconds):
    stamp_ns = round((1000.0 + seconds) * SECOND_NS)
    return replace(NOTHING, stamp_ns=stamp_ns, pose=replace(NOTHING.pose, stamp_ns=stamp_ns))


def test_sightings_are_numbered_and_can_be_had_again_as_long_as_they_are_kept():
    box = Outbox("a")
    sent = [box.add(at(k / 10)) for k in range(740)]
    assert [one.sequence for one in sent] == list(range(740))
    assert {one.session for one in sent} == {1000 * SECOND_NS}
    assert sent[640].oldest == 0
    assert sent[641].oldest == 1
    assert sent[739].oldest == 99
    again = box.between(1000 * SECOND_NS, 90, 110)
    assert [one.sequence for one in again] == list(range(99, 111))
    assert again[0].sighting is sent[99].sighting
    assert {one.oldest for one in again} == {99}
    assert [one.sequence for one in box.between(1000 * SECOND_NS, 738, 800)] == [738, 739]
    assert box.between(1, 90, 110) == []
    assert box.between(1000 * SECOND_NS, 0, 98) == []
    assert Outbox("a").between(0, 0, 5) == []


def test_the_number_of_sightings_kept_is_bounded():
    box = Outbox("a")
    for k in range(TUNING.most + 10):
        sent = box.add(at(k / 1000))
    assert sent.oldest == 10


def test_a_clock_that_goes_backward_begins_a_session():
    box = Outbox("a")
    box.add(at(10.0))
    near = box.add(at(10.0 - TUNING.backward_s))
    assert (near.session, near.sequence) == (1010 * SECOND_NS, 1)
    sent = box.add(at(5.0 - 2 * TUNING.backward_s))
    assert (sent.session, sent.sequence, sent.oldest) == (999 * SECOND_NS, 0, 0)
    assert box.between(1010 * SECOND_NS, 0, 9) == []
