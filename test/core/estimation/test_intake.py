# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Messages are kept or refused, counted, and reported once."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.intake import LONG_S, Intake
from aerial_gnss_ros.core.estimation.time_base import TimeBase
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.input_status import InputState
from aerial_gnss_ros.core.telemetry.stamp_decision import Decision
from aerial_gnss_ros.core.values.detection_frame import empty_detections
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Input
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

SECOND = 1_000_000_000


class Receiver:
    """Notes what it is given."""

    def __init__(self):
        self.got, self.refusal = [], ""

    def receive_fix(self, fix):
        """Take a fix."""
        self.got.append(fix)
        return self.refusal

    def receive_image(self, frame):
        """Take an image."""
        self.got.append(frame)

    def begin_elsewhere(self, moved):
        """Take in that the drone is elsewhere."""
        self.got.append(moved)

    def note_lead(self):
        """Take in that stamps of telemetry lead."""
        self.got.append("lead")

    def note_correction(self):
        """Take in that telemetry was wrong."""
        self.got.append("corrected")

    def reset_time(self, decision, passed_s):
        """Note that time was reset."""
        self.got.append((decision, passed_s))


class Door:
    """An intake with what it acts on."""

    def __init__(self, values=None):
        config = estimator_config(values or {})
        self.inputs, self.receiver, self.log = TelemetryBuffers(config), Receiver(), Events()
        self.time = TimeBase()
        self.intake = Intake(config, self.inputs, self.time, Counter(), self.log, self.receiver)

    def status(self, name):
        """Return an input's status."""
        return self.intake.statuses(SECOND)[name]


def fix(t, latitude=0.2):
    return Fix(round(t * SECOND), latitude, -1.0, 5.0)


def test_a_usable_fix_is_kept_handed_on_and_counted():
    door = Door()
    door.intake.add_fix(fix(1.0))
    assert door.receiver.got == [fix(1.0)]
    assert door.inputs._buffers[Input.FIX].series.last == fix(1.0)
    status = door.status("fix")
    assert (status.state, status.count, status.bad) == (InputState.OK, 1, 0)
    assert door.log.drain() == []


def test_a_fix_that_is_no_use_or_too_far_away_is_counted_and_reported_once():
    door = Door()
    for t in (1.0, 1.1):
        door.intake.add_fix(fix(t, math.nan))
    assert door.receiver.got == []  # nobody else sees it
    (words,) = door.log.drain()
    assert words.startswith("A message on fix is of no use: ")
    assert (door.status("fix").count, door.status("fix").bad) == (2, 2)
    far = Door()
    far.receiver.refusal = "it is too far away"
    far.intake.add_fix(fix(1.0))
    assert far.status("fix").trouble == "it is too far away"


@pytest.mark.parametrize(("last_s", "reported"), [(LONG_S, 0), (LONG_S + 0.1, 1)])
def test_an_input_of_no_use_for_long_is_reported_again(last_s, reported):
    door = Door()
    door.intake.add(Input.HEIGHT, Scalar(SECOND, 20.0))
    for t in (*np.arange(0.5, last_s, 0.5).tolist(), last_s):
        door.intake.add(Input.HEIGHT, Scalar(round((1.0 + t) * SECOND), math.nan))
    again = [one for one in door.log.drain() if one.startswith("No message on height has been of")]
    assert len(again) == reported


def test_a_message_that_cannot_be_read_or_is_unknown_is_counted():
    door = Door()
    for name in ("gimbal", "sonar"):
        door.intake.refuse(name, "it is cut off")
        assert door.intake.tallies[name].bad == 1
    assert len(door.log.drain()) == 2


def test_an_exception_while_a_sample_is_kept_is_its_trouble(monkeypatch):
    door = Door()
    monkeypatch.setattr(door.inputs, "add", lambda *_: 1 // 0)
    door.intake.add(Input.HEIGHT, Scalar(SECOND, 20.0))
    assert door.status("height").trouble.startswith("it cannot be kept (ZeroDivisionError: ")


def test_a_camera_that_cannot_be_used_is_counted_as_bad_and_holds():
    door = Door()
    door.intake.add_camera(SECOND, None)
    assert door.status("camera_info").trouble == "it describes no camera"
    assert door.inputs.cameras.at(SECOND) == "bad_camera_info"


def test_samples_are_kept_by_time_not_by_stamp_once_a_clock_was_set(sea):
    door = Door({"depth.topics": ["depth"]})
    door.time.step(-100 * SECOND, 0)  # stamps went back by 100 s
    door.intake.add(Input.HEIGHT, Scalar(SECOND, 20.0))
    door.intake.add(Input.GIMBAL, Orientation(SECOND, np.array([0.0, 0.0, 0.0, 1.0])))
    door.intake.add_fix(fix(1.0))
    door.intake.add_camera(SECOND, sea.camera)
    door.intake.add_water_level(Scalar(SECOND, 0.5))
    door.intake.add_depth("", Scalar(SECOND, 0.3))
    scene = door.inputs.at(101 * SECOND)
    assert (scene.height, scene.fix.stamp_ns, scene.water_level) == (20.0, 101 * SECOND, 0.5)
    assert door.inputs.cameras.at(101 * SECOND) is sea.camera
    assert door.inputs.cameras.at(100 * SECOND) == "no_camera_info"
    assert door.inputs.depths.at(("aqua",), 101 * SECOND).tolist() == [0.3]


def test_where_the_drone_turns_out_to_be_elsewhere_the_receiver_is_named():
    """Heights of 20 m, then 500 m for longer than `limits.height_settle_s`."""
    door = Door({"limits.height_settle_s": 3.0})
    for i in range(60):
        height = (20.0 if i < 20 else 500.0) + 0.01 * (i % 3)
        door.intake.add(Input.HEIGHT, Scalar(i * SECOND // 10, height))
    (words,) = door.receiver.got
    assert words == "The height is 500.0 m, 480 m from what it was before"


def test_where_the_water_turns_out_to_be_elsewhere_the_receiver_is_named():
    door = Door()
    for i in range(20):
        door.intake.add_water_level(Scalar(i * SECOND, 0.0 if i < 5 else 30.0))
    assert door.receiver.got == ["The water is 30 m from where it was before"]


def test_an_input_is_stale_by_the_newest_image():
    door = Door()
    door.intake.add_fix(fix(1.0))
    for t in (2.0, 1.5):
        door.intake.add_detections(empty_detections(round(t * SECOND)))
    assert door.status("fix").state is InputState.OK
    door.intake.add_detections(empty_detections(round(2.1 * SECOND)))
    assert door.status("fix").state is InputState.STALE


@pytest.mark.parametrize(("steady", "passed_s"), [(True, 1.5), (False, None)])
def test_a_reset_of_time_is_told_with_the_time_since_the_last_image(steady, passed_s):
    """The node's clock and a steady one go on alike for 5 s; the image is 1.5 s before the end."""
    door = Door()
    for i in range(11):
        now_ns = i * SECOND // 2
        door.intake.tick(now_ns, 70 * SECOND + now_ns if steady else None)
        if i == 7:
            door.intake.add_detections(empty_detections(now_ns))
    door.receiver.got.clear()
    decision = Decision(False, ("fix",))
    door.intake._reset_time(decision)
    assert door.receiver.got == [(decision, passed_s)]
    assert door.status("detections").last_stamp_ns == 7 * SECOND // 2
    door.intake._reset_time(replace(decision, time_reset=True))
    assert door.status("detections").last_stamp_ns is None
