# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Telemetry that never matches images is reported once, with how far it is off."""

from __future__ import annotations

from dataclasses import replace

import pytest

from aerial_gnss_ros.core.estimation.unmatched_telemetry import UnmatchedTelemetry
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry
from aerial_gnss_ros.core.values.events import Events, WarningText
from aerial_gnss_ros.core.values.rejection import Input, Reason

SECOND = 1_000_000_000
LATE_FIX = MissingTelemetry(Reason.STALE_FIX, can_arrive=True)
LATE_GIMBAL = MissingTelemetry(Reason.STALE_GIMBAL, can_arrive=True)
NO_FIX = MissingTelemetry(Reason.NO_FIX, can_arrive=False)


def sentences(images):
    """Return what is said of images (time of the scene, s, and its telemetry); fix ends at 60 s."""
    log = Events()
    unmatched = UnmatchedTelemetry(3.0, log)
    for t, samples in images:
        unmatched.update(round(t * SECOND), samples, {Input.FIX: 60 * SECOND})
    return log.drain()


@pytest.mark.parametrize(("later_s", "reported"), [(2.9, 0), (3.1, 1)])
def test_an_input_that_begins_long_after_an_image_is_reported_once(later_s, reported):
    lacking = MissingTelemetry(Reason.NO_FIX, False, later_s)
    told = sentences([(50.0, lacking), (50.1, lacking)])
    assert len(told) == reported
    assert all(one.startswith("The oldest fix is 3.1 s later than an image") for one in told)


def test_an_input_that_is_late_for_10_s_is_reported_once_with_its_distance():
    (one,) = sentences((90.0 + 0.5 * i, LATE_FIX) for i in range(60))
    assert isinstance(one, WarningText)
    assert "the newest fix was 40.0 s earlier than it" in one  # at the image of 100 s
    assert "fix.stamp selects" in one


@pytest.mark.parametrize("other", ["telemetry is there", LATE_GIMBAL, NO_FIX])
def test_one_image_with_another_outcome_begins_the_10_s_anew(other):
    images = [(90.0 + i, LATE_FIX) for i in range(20)]
    images[8] = (98.0, other)
    assert len(sentences(images[:19])) == 0  # 99 to 108 s
    assert len(sentences(images)) == 1


@pytest.mark.parametrize(
    ("images_s", "arrival_s", "off"), [(30.0, 0.0, "30.0 s"), (0.0, 5.0, "5.0 s")]
)
def test_images_ahead_and_telemetry_that_arrives_late_are_reported(sea, images_s, arrival_s, off):
    """All telemetry, at 20 Hz, arrives with the images, or 5 s after them."""
    engine, world = sea.estimator(), sea.World()
    engine.add_camera(sea.stamp(0.0), sea.camera)
    results = []
    for i in range(400):
        t = 0.05 * i
        if t >= arrival_s:
            for name in ("fix", "gimbal", "height"):
                getattr(engine, f"add_{name}")(getattr(world, name)(t - arrival_s))
        if i % 4 == 0 and t >= 6.0:
            image = sea.boxes(t, [sea.middle])
            engine.add_detections(replace(image, stamp_ns=sea.stamp(t + images_s)))
        results += engine.advance(sea.stamp(t))
    assert {one.reason for each in results for one in each.rejections} == {Reason.STALE_FIX}
    (one,) = [one for one in engine.take_events() if "stale_fix" in one]
    assert f"the newest fix was {off} earlier" in one
