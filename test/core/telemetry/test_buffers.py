# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What telemetry was at the time of a scene, or which input it lacks."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.input_status import InputState, MessageCounter
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry, SceneTelemetry
from aerial_gnss_ros.core.values.rejection import Input, Reason
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar


@pytest.mark.parametrize("latency_s", [0.0, 0.25, -0.25])
def test_a_fix_and_a_height_that_are_stamped_late(latency_s) -> None:
    """They rise by 1e-6 rad and 1 m a second; stamped 0.25 s late, they stand that much farther."""
    late = {"latency_s": latency_s}
    inputs = TelemetryBuffers(estimator_config({"fix": late, "height": late}))
    level = np.array([0.0, 0.0, 0.0, 1.0])
    for k in range(41):
        stamp = 10**18 + k * 100_000_000
        inputs.add(Input.GIMBAL, Orientation(stamp, level))
        inputs.add(Input.FIX, Fix(stamp, 0.2 + 1e-7 * k, -1.0, 0.0))
        inputs.add(Input.HEIGHT, Scalar(stamp, 20.0 + 0.1 * k))
    first, last = 10**18 + 1_000_000_000, 10**18 + 1_200_000_000
    sent = [first, first + 100_000_000, last]
    assert inputs.stamps(first, last) == [sent, sent, sent]  # as sent
    found = inputs.at(10**18 + 2_000_000_000)
    assert isinstance(found, SceneTelemetry)
    assert found.fix.latitude - 0.2 == pytest.approx(1e-6 * (2.0 + latency_s), abs=1e-10)
    assert found.height == pytest.approx(22.0 + latency_s)


def test_a_fix_that_is_found_later_is_of_its_own_stamp_and_is_waited_for():
    inputs = filled(dict.fromkeys(SENT, (0.9, 1.1, 1.3)))
    inputs.fix_later_ns = 150_000_000
    found = inputs.at(10**9)
    assert found.fix.stamp_ns == 1_150_000_000
    assert found.height == inputs.at(10**9).height == pytest.approx(20.0, abs=0.1)
    awaited = inputs.at(1_200_000_000)
    assert (awaited.reason, awaited.can_arrive) == (Reason.STALE_FIX, True)
    inputs.fix_later_ns = -150_000_000
    assert inputs.at(1_200_000_000).fix.stamp_ns == 1_050_000_000
    assert inputs.at(1_000_000_000).reason == Reason.NO_FIX


LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
SENT = {
    Input.FIX: lambda ns: Fix(ns, 0.2 + 1e-9 * (ns % 100), -1.0, 5.0),
    Input.GIMBAL: lambda ns: Orientation(ns, LEVEL),
    Input.HEIGHT: lambda ns: Scalar(ns, 20.0 + 0.001 * (ns % 100)),
}


def filled(times, values=None):
    """Return buffers with samples at times, s, by input."""
    inputs = TelemetryBuffers(estimator_config(values or {}))
    for source, stamps in times.items():
        for k, t in enumerate(stamps):
            assert inputs.add(source, SENT[source](round(t * 1e9) + k)) == ""
    return inputs


def test_the_newest_time_is_that_of_inputs_that_sent_something():
    config = estimator_config({"height.latency_s": 0.25})
    inputs = TelemetryBuffers(config)
    for source in (Input.FIX, Input.HEIGHT):
        for stamp in (2 * 10**9, 10**9):
            inputs.add(source, SENT[source](stamp))
    assert inputs.newest_ns() == {Input.FIX: 2_000_000_000, Input.HEIGHT: 1_750_000_000}


def test_the_oldest_sample_of_a_scene_is_that_of_the_worst_input():
    inputs = filled({Input.FIX: (0.9, 1.1), Input.GIMBAL: (0.95, 1.3), Input.HEIGHT: (1.0, 1.2)})
    assert inputs.at(10**9).oldest_age_s == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("changed", "reason", "can_arrive", "later_s"),
    [
        ({Input.FIX: ()}, Reason.NO_FIX, True, 0.0),
        ({Input.HEIGHT: (0.9,)}, Reason.STALE_HEIGHT, True, 0.0),
        ({Input.GIMBAL: (3.5, 3.6)}, Reason.NO_GIMBAL, False, 2.5),
        # What can never come is the reason, wherever it stands.
        ({Input.FIX: (0.9,), Input.HEIGHT: (-9.0, 9.0)}, Reason.GAP_HEIGHT, False, 0.0),
        ({Input.FIX: (-9.0, 9.0), Input.HEIGHT: (0.9,)}, Reason.GAP_FIX, False, 0.0),
    ],
)
def test_the_input_that_a_scene_lacks_is_named(changed, reason, can_arrive, later_s):
    inputs = filled(dict.fromkeys(SENT, (0.9, 1.1)) | changed)
    found = inputs.at(10**9)
    assert isinstance(found, MissingTelemetry)
    assert (found.reason, found.can_arrive) == (reason, can_arrive)
    assert found.later_s == pytest.approx(later_s)


def test_the_inputs_of_a_mast_are_constants_and_need_no_messages():
    inputs = TelemetryBuffers(
        estimator_config(
            {"fix.source": "constant", "fix.latitude_deg": 30.0, "fix.longitude_deg": -60.0}
            | {"gimbal.source": "constant", "gimbal.rpy_deg": [0.0, 90.0, 0.0]}
            | {"height.source": "constant", "height.value_m": 12.0, "water_level.value_m": 0.5}
        )
    )
    scene = inputs.at(7)
    assert [scene.fix.latitude, scene.fix.longitude] == pytest.approx([math.pi / 6, -math.pi / 3])
    assert scene.gimbal.quaternion == pytest.approx([0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5)])
    assert (scene.height, scene.water_level, scene.attitude) == (12.0, 0.5, None)
    assert inputs.constant_fix == scene.fix
    states = {one: inputs.state_without_messages(one) for one in Input}
    assert states.pop(Input.ATTITUDE) is InputState.UNUSED
    assert set(states.values()) == {InputState.CONSTANT}


@pytest.mark.parametrize(
    ("name", "values", "state"),
    [
        ("fix", {}, InputState.STALE),
        ("detections", {}, InputState.STALE),
        ("camera_info", {}, InputState.OK),  # it holds until replaced
        ("water_level", {}, InputState.OK),
        ("attitude", {}, InputState.UNUSED),
        ("attitude", {"gimbal.reference": "heading"}, InputState.STALE),
    ],
)
def test_the_status_of_an_input_allows_for_what_needs_no_messages(name, values, state):
    counter = MessageCounter()
    counter.add(0)
    inputs = TelemetryBuffers(estimator_config(values))
    assert inputs.without_messages(counter.status(name, 10**10, 10**9)).state is state


def test_a_level_that_nobody_sends_is_a_constant():
    inputs = TelemetryBuffers(estimator_config({}))
    none = MessageCounter().status("water_level", None, 10**9)
    assert inputs.without_messages(none).state is InputState.CONSTANT


def test_time_that_begins_anew_forgets_samples_but_not_the_level_of_the_water():
    inputs = filled(dict.fromkeys(SENT, (0.9, 1.1)))
    assert inputs.add_level(Scalar(0, 1.5)) == ""
    assert inputs.at(10**9).water_level == 1.5
    inputs.clear(kept=("height",))
    assert inputs.at(10**9).reason is Reason.NO_FIX
    for source in (Input.FIX, Input.GIMBAL):
        for t in (0.9, 1.1):
            inputs.add(source, SENT[source](round(t * 1e9)))
    assert inputs.at(10**9).water_level == 1.5


def test_inputs_whose_clocks_were_set_are_forgotten_alone():
    inputs = filled(dict.fromkeys(SENT, (0.9, 1.1)))
    inputs.forget(("height",))
    assert inputs.at(10**9).reason is Reason.NO_HEIGHT


def test_values_that_are_sent_again_are_interpolated_between_measurements():
    """Heights of 1 Hz at 4 Hz rise by 1 m a second; so they do before that was known, too."""
    inputs = TelemetryBuffers(estimator_config({}))
    for k in range(21):
        ns, measured = 10**18 + k * 250_000_000, k // 4
        inputs.add(Input.FIX, Fix(ns, 0.2 + 1e-7 * measured, -1.0, 0.0))
        inputs.add(Input.GIMBAL, Orientation(ns, LEVEL))
        inputs.add(Input.HEIGHT, Scalar(ns, 20.0 + measured))
        assert inputs.sent_again == ([Input.FIX] if k >= 12 else [])
    for t in (0.75, 1.5, 3.8):
        found = inputs.at(10**18 + round(t * 1e9))
        assert found.height == pytest.approx(20.0 + t)
        assert found.fix.latitude == pytest.approx(0.2 + 1e-7 * t, abs=1e-13)
    inputs.clear()
    for k in range(2):
        inputs.add(Input.HEIGHT, Scalar(2 * 10**18 + k, 20.0))
    assert len(inputs._buffers[Input.HEIGHT].series.values) == 2  # whether it is so is open again


def test_each_input_is_judged_by_itself():
    """The heading of 2 Hz at 4 Hz turns by 0.1 rad a second; positions are all measured."""
    inputs = TelemetryBuffers(estimator_config({}))
    for k in range(33):
        ns, angle = 10**18 + k * 250_000_000, 0.1 * 0.5 * (k // 2)
        turned = np.array([0.0, 0.0, math.sin(0.5 * angle), math.cos(0.5 * angle)])
        inputs.add(Input.FIX, Fix(ns, 0.2 + 1e-9 * k, -1.0, 0.0))
        inputs.add(Input.GIMBAL, Orientation(ns, turned))
        inputs.add(Input.HEIGHT, Scalar(ns, 20.0))
        assert inputs.sent_again == ([Input.GIMBAL] if k >= 20 else [])
    found = inputs.at(10**18 + 1_300_000_000)
    assert 2.0 * math.asin(found.gimbal.quaternion[2]) == pytest.approx(0.13)
    assert len(inputs._buffers[Input.HEIGHT].series.values) == 33


def test_one_wrong_fix_is_told_when_the_next_one_comes_and_is_never_used():
    buffers = TelemetryBuffers(estimator_config({}))
    told = [
        buffers.add(Input.FIX, Fix(k * 10**8, 0.2 + (1e-6 if k == 30 else 0.0), 0.1, 0.0))
        for k in range(33)
    ]
    assert [bool(one) for one in told] == [False] * 31 + [True, False]
    assert told[31] == "it lies 6.3 m off those before and after it, which agree"
    assert len(buffers.stamps(0, 10**10)[0]) == 32
    for k in range(40):
        yaw = math.radians(25.0) if k == 30 else 0.0
        gimbal = np.array([0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)])
        trouble = buffers.add(Input.GIMBAL, Orientation(k * 10**8, gimbal))
        assert bool(trouble) == (k == 31)
        assert "25 deg" in trouble or not trouble


def test_a_sample_of_no_use_ends_what_is_held():
    buffers = TelemetryBuffers(estimator_config({}))
    for k in range(31):
        buffers.add(Input.FIX, Fix(k * 10**8, 0.2 + (1e-6 if k == 30 else 0.0), 0.1, 0.0))
    assert buffers.newest_ns()[Input.FIX] == 29 * 10**8
    buffers.add(Input.FIX, Fix(31 * 10**8, 0.2, 0.1, 0.0, valid=False))
    assert buffers.stamps(29 * 10**8, 10**10)[0] == [29 * 10**8, 30 * 10**8, 31 * 10**8]


def test_a_jump_tells_how_far_the_receiver_is_and_is_no_motion_between_samples():
    constant = {"gimbal": {"source": "constant"}, "height": {"source": "constant", "value_m": 20.0}}
    buffers = TelemetryBuffers(estimator_config(constant))
    for k in range(60):
        buffers.add(Input.FIX, Fix(k * 10**8, 0.2 + (1e-6 if k >= 30 else 0.0), 0.1, 0.0))
    before, across, after = (buffers.at(round(t * 1e9)) for t in (2.85, 2.95, 3.05))
    assert before.fix.jumped == across.fix.jumped == ()
    assert across.fix.latitude == pytest.approx(0.2, abs=1e-9)
    assert after.fix.jumped == pytest.approx((0.0, 6.3), abs=0.1)
    assert after.uncertain[Input.FIX].variance == pytest.approx(
        before.uncertain[Input.FIX].variance
    )
