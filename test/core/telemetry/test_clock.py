# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The limits by which stamps are judged, one by one."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.telemetry.clock import Clock
from aerial_gnss_ros.core.telemetry.stamp_decision import Decision, Verdict

ON, BACK, OFF, ELSEWHERE = Verdict.GOES_ON, Verdict.RETURNS, Verdict.FAR_OFF, Verdict.ELSEWHERE
TELEMETRY = ("fix", "gimbal", "height")


def ns(seconds):
    return round(seconds * 1e9)


class Times:
    """A clock with seconds."""

    def __init__(self, needed=TELEMETRY, held=()):
        self.clock = Clock(needed, held)

    def judge(self, name, *stamps):
        return [self.clock.judge(name, ns(stamp)) for stamp in stamps]

    def tick(self, now):
        self.clock.tick(ns(now))
        return self.clock.silent()

    def run(self, begin, end, names=(*TELEMETRY, "detections"), off=0.0):
        """Let 10 stamps a second come, whatever they are."""
        for i in range(round((end - begin) * 10)):
            for name in names:
                self.judge(name, begin + 0.1 * i + off)
            self.tick(begin + 0.1 * i)
        return self

    def decision(self, name):
        return self.clock.decision(name)


@pytest.mark.parametrize(
    ("stamp", "verdict"), [(8.1, ON), (7.8, OFF), (10.4, ON), (10.6, OFF), (12.1, OFF), (9.9, ON)]
)
def test_a_stamp_may_be_2_s_late_or_half_a_second_early(stamp, verdict):
    times = Times().run(0.0, 10.0)  # the newest is 9.9, the next one 10.0
    assert times.judge("fix", stamp) == [verdict]


@pytest.mark.parametrize(("stamp", "verdict"), [(60.4, ON), (60.6, OFF), (62.2, OFF)])
def test_and_as_much_later_as_time_has_passed(stamp, verdict):
    times = Times().run(0.0, 10.0)
    times.tick(60.0)
    assert times.judge("fix", stamp) == [verdict]


def test_a_pause_is_known_from_the_node_s_time():
    times = Times().run(0.0, 10.0)
    assert times.judge("fix", 60.0) == [OFF]
    assert times.tick(10.0) == ()
    assert times.tick(59.4) == ()
    assert times.tick(59.6) == ("fix",)
    times.clock.goes_on("fix")
    assert times.judge("fix", 60.0, 60.1) == [ON, ON]


def test_what_is_behind_was_no_pause():
    times = Times().run(0.0, 10.0)
    assert times.judge("fix", 3.0) == [OFF]
    assert times.tick(60.0) == ()


def test_delays_of_the_first_messages_do_not_count():
    """The largest lead over the node's clock does: a first message may have been on its way."""
    times = Times()
    times.tick(5.0)
    times.judge("fix", 0.0)
    for i in range(1, 40):
        times.judge("fix", 0.1 * i)
        times.tick(5.0 + 0.02 * i)  # catches up
    assert times.tick(20.0) == ()
    assert times.judge("fix", 18.7) == [OFF]  # the last one was 1.88 s late
    assert times.judge("fix", 18.5) == [BACK]


def test_a_node_s_clock_that_is_set_is_followed():
    times = Times().run(0.0, 10.0)
    for i in range(20):  # an hour later by the node's clock alone
        times.tick(3610.0 + 0.1 * i)
        assert times.judge("fix", 10.0 + 0.1 * i) == [ON]
    assert times.judge("fix", 1000.0) == [OFF]
    assert times.tick(3612.1) == ()


def test_until_a_stamp_came_after_the_node_s_clock_was_set_leads_are_unknown():
    times = Times().run(0.0, 10.0)
    assert times.tick(-90.0) == ()
    assert times.judge("fix", 60.0) == [OFF]
    assert times.tick(-90.0) == ("fix",)  # nothing speaks against it
    assert times.judge("gimbal", 10.0) == [ON]
    assert times.judge("gimbal", 60.0) == [OFF]
    assert times.tick(-90.0) == ("fix",)


def test_stamps_that_return_or_are_elsewhere_end_a_rival():
    times = Times().run(0.0, 10.0)
    assert times.judge("fix", 500.0, 500.1, 700.0, 10.0, 10.1) == [OFF, OFF, ELSEWHERE, BACK, ON]
    assert times.clock.newest("fix") == ns(10.1)


def test_values_that_hold_may_be_stamped_long_ago():
    times = Times(held=("camera_info",))
    assert times.judge("camera_info", 100.0, 0.0, 100.0, 103.0) == [ON, ON, ON, OFF]
    assert times.clock.apart_s("camera_info") == pytest.approx(3.0)


def begun_anew(times, off, names, images=2):
    """Return the decision after messages of some inputs, then images, moved."""
    for name in names:
        times.judge(name, 10.0 + off)
        assert times.decision(name) is None
    for i in range(images):
        assert times.judge("detections", 10.0 + off + 0.1 * i)[0] is OFF
    return times.decision("detections")


@pytest.mark.parametrize(
    ("names", "images", "time_reset"),
    [
        (TELEMETRY, 2, True),
        (TELEMETRY, 1, False),
        (TELEMETRY[:2], 2, True),
        (TELEMETRY[:1], 2, False),
        (("attitude", "camera_info"), 5, False),  # nobody needs them
        ((), 20, False),
    ],
)
@pytest.mark.parametrize("off", [-5.0, -100.0, 100.0])
def test_most_needed_inputs_decide_whether_time_began_anew(names, images, time_reset, off):
    times = Times().run(0.0, 10.0, (*TELEMETRY, "attitude", "camera_info", "detections"))
    decision = begun_anew(times, off, names, images)
    assert (decision is not None) == time_reset
    if time_reset:
        assert decision.time_reset
        assert set(decision.moved) == {"detections", *names}
        assert decision.by_ns == pytest.approx(ns(off), abs=ns(0.3))


@pytest.mark.parametrize(("apart", "time_reset"), [(2.5, True), (3.5, False)])
def test_what_moved_otherwise_is_no_witness(apart, time_reset):
    times = Times(("fix",)).run(0.0, 10.0, ("fix", "detections"))
    times.judge("fix", 110.0 + apart)
    times.judge("detections", 110.0, 110.1)
    assert (times.decision("detections") is not None) == time_reset


@pytest.mark.parametrize(("seconds", "time_reset"), [(9.5, False), (10.5, True)])
def test_images_alone_are_followed_after_10_s(seconds, time_reset):
    times = Times().run(0.0, 10.0)
    times.run(10.0, 10.0 + seconds, TELEMETRY)
    times.judge("detections", 110.0)
    for i in range(round(seconds * 10)):
        times.judge("detections", 110.0 + 0.1 * i)
    assert (times.decision("detections") is not None) == time_reset


@pytest.mark.parametrize(("images", "time_reset"), [(3, False), (4, True)])
def test_without_other_inputs_four_images_decide(images, time_reset):
    times = Times(()).run(0.0, 10.0, ("detections",))
    times.judge("detections", *(1000.0 + 0.1 * i for i in range(images)))
    assert (times.decision("detections") is not None) == time_reset


@pytest.mark.parametrize(("step", "time_reset"), [(-100.0, True), (-96.0, False), (-104.0, False)])
def test_the_node_s_clock_is_a_witness_where_it_steps_along(step, time_reset):
    times = Times().run(0.0, 10.0)
    times.tick(9.9 + step)
    times.judge("detections", -90.0)
    decision = times.decision("detections")
    assert (decision is not None) == time_reset
    if time_reset:
        assert "clock" in decision.moved


def test_inputs_that_went_on_speak_against_the_node_s_clock():
    times = Times().run(0.0, 10.0)
    times.tick(-90.1)
    for name in TELEMETRY:
        times.judge(name, 10.0)
    times.judge("detections", -90.0)
    assert times.decision("detections") is None


def test_images_that_come_to_the_time_of_telemetry():
    times = Times().run(0.0, 10.0, TELEMETRY).run(9.0, 10.0, ("detections",), off=-500.0)
    times.judge("detections", 10.0)
    assert times.decision("detections") is None
    times.judge("detections", 10.1)
    decision = times.decision("detections")
    assert (set(decision.moved), set(decision.kept)) == ({"detections"}, set(TELEMETRY))
    times.clock.believe(decision)
    assert times.judge("fix", 10.1, 500.0) == [ON, OFF]  # its line is still there
    assert times.judge("detections", 10.2) == [ON]


def test_telemetry_that_comes_to_the_time_of_images():
    times = Times().run(0.0, 10.0, ("detections",)).run(9.0, 10.0, ("fix",), off=-500.0)
    times.judge("fix", 10.0, 10.1)
    assert times.decision("fix") is None
    times.judge("fix", 10.2)
    decision = times.decision("fix")
    assert decision == Decision(False, ("fix",))
    times.clock.believe(decision)
    assert times.judge("fix", 10.2) == [ON]
    assert times.judge("detections", 10.0) == [ON]


def test_telemetry_that_leaves_the_images_is_followed_after_10_s():
    times = Times().run(0.0, 10.0)
    times.judge("fix", *(500.0 + 0.1 * i for i in range(100)))
    assert times.decision("fix") is None
    times.judge("fix", 510.1)
    assert times.decision("fix") == Decision(False, ("fix",))


def test_a_wrong_first_stamp_is_outvoted_by_two():
    times = Times()
    times.judge("fix", 500.0, 0.0)
    assert times.decision("fix") is None
    times.judge("fix", 0.1)
    assert times.decision("fix") == Decision(False, ("fix",))


def leading(by, *, seconds=10.0, names=("fix",), every=0.1, begin=10.0, run=10.0, now=0.0):
    """Return for each of some inputs when its stamps, early by so much, were believed, s."""
    times, believed = Times().run(begin - run, begin), {}
    for i in range(round(seconds / 0.1)):
        t = begin + 0.1 * i
        for name in (*TELEMETRY, "detections"):
            step = every if name in names else 0.1
            if round(t / step, 6) != round(t / step):
                continue
            times.judge(name, t + (by if name in names else 0.0))
            for silent in times.tick(t + now):
                times.clock.goes_on(silent)
                believed.setdefault(silent, round(t - begin, 1))
            assert times.decision(name) is None  # nothing is cleared
    return believed


@pytest.mark.parametrize("name", [*TELEMETRY, "detections"])
@pytest.mark.parametrize("by", [0.65, 1.9])
def test_early_stamps_of_one_input_wait_until_they_outlast_those_before(name, by):
    assert leading(by, names=(name,), seconds=9.9) == {}
    assert leading(by, names=(name,), seconds=11.0) == {name: 9.9}
    assert leading(by, names=(name,), run=2.0) == {name: 1.9}
    assert leading(by, names=(name,), every=1.0, seconds=9.9) == {}


def test_early_stamps_leave_the_line_where_it_is():
    times = Times().run(0.0, 10.0)
    for i in range(5):
        assert times.judge("fix", 11.5 + 0.1 * i)[0] is OFF
        assert times.tick(10.0 + 0.1 * i) == ()
    assert times.judge("fix", 10.5, 10.6) == [BACK, ON]
    assert times.tick(10.6) == ()
    assert times.judge("fix", 12.1) == [OFF]  # their lead was not learned


@pytest.mark.parametrize("by", [0.65, 1.9])
def test_where_all_inputs_lead_alike_they_go_on(by):
    """The clock that stamps them was set, or a piece of a recording is cut out."""
    believed = leading(by, names=(*TELEMETRY, "detections"))
    assert set(believed) == {*TELEMETRY, "detections"}
    assert max(believed.values()) <= 0.2


def test_one_that_comes_seldom_goes_on_as_the_others_did():
    times, every = Times(), (*TELEMETRY, "detections")
    times.run(0.0, 10.0)
    for i in range(30):
        t = 10.0 + 0.1 * i
        for name in every:
            if name == "height" and i not in (9, 19):
                continue
            times.judge(name, t + 1.5)
            for silent in times.tick(t):
                times.clock.goes_on(silent)
        assert (times.clock.newest("height") > ns(12.0)) == (i >= 9)


def test_telemetry_that_leads_without_the_images_waits():
    assert leading(1.5, names=TELEMETRY, seconds=5.0) == {}


def test_the_node_s_clock_may_be_set_back_by_a_second():
    assert leading(0.0, names=(), now=-1.0) == {}
    times = Times().run(0.0, 10.0)
    times.tick(8.9)
    assert times.judge("fix", 10.0) == [ON]
    times.tick(8.9)
    assert times.judge("fix", 10.1, 11.5) == [ON, OFF]


@pytest.mark.parametrize(("apart", "rate"), [(0.1, 2.0), (1.0, 5.0), (1.9, 3.0)])
def test_stamps_that_come_as_far_apart_as_ever_are_not_early(apart, rate):
    """A recording that is played fast, and the node's clock does not know."""
    times = Times()
    for i in range(60):
        assert times.judge("fix", apart * i) == [ON]
        times.tick(apart * i / rate)


def test_a_network_that_recovers_brings_nothing_early():
    """What it held comes at once, with losses; nothing is nearer to its stamp than at first."""
    times = Times().run(0.0, 10.0)
    for stamp, now in ((10.0, 12.0), (10.5, 13.0), (11.0, 13.5), (13.0, 13.6), (13.6, 13.6)):
        times.tick(now)
        assert times.judge("fix", stamp) == [ON]
