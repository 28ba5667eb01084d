# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The limits by which stamps are judged, one by one."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.telemetry.clock import Clock, Decision, Verdict

ON, BACK, OFF, ELSEWHERE = Verdict.GOES_ON, Verdict.RETURNS, Verdict.FAR_OFF, Verdict.ELSEWHERE
TELEMETRY = ("fix", "gimbal", "height")


def ns(seconds):
    return round(seconds * 1e9)


class Times:
    """A clock with seconds."""

    def __init__(self, needed=TELEMETRY, held=()):
        self.clock = Clock(needed, held)

    def take(self, name, *stamps):
        return [self.clock.take(name, ns(stamp)) for stamp in stamps]

    def tick(self, now):
        self.clock.tick(ns(now))
        return self.clock.silent()

    def run(self, begin, end, names=(*TELEMETRY, "detections"), off=0.0):
        """Let 10 stamps a second come, whatever they are."""
        for i in range(round((end - begin) * 10)):
            for name in names:
                self.take(name, begin + 0.1 * i + off)
            self.tick(begin + 0.1 * i)
        return self

    def decision(self, name):
        return self.clock.decision(name)


@pytest.mark.parametrize(
    ("stamp", "verdict"), [(8.1, ON), (7.8, OFF), (11.8, ON), (12.1, OFF), (9.9, ON)]
)
def test_a_stamp_may_be_2_s_late_or_ahead(stamp, verdict):
    times = Times().run(0.0, 10.0)  # the newest is 9.9
    assert times.take("fix", stamp) == [verdict]


@pytest.mark.parametrize(("stamp", "verdict"), [(61.9, ON), (62.2, OFF)])
def test_and_as_much_later_as_time_has_passed(stamp, verdict):
    times = Times().run(0.0, 10.0)
    times.tick(60.0)
    assert times.take("fix", stamp) == [verdict]


def test_a_pause_is_known_when_the_node_s_time_is_told():
    times = Times().run(0.0, 10.0)
    assert times.take("fix", 60.0) == [OFF]
    assert times.tick(10.0) == ()
    assert times.tick(57.8) == ()
    assert times.tick(58.1) == ("fix",)
    times.clock.goes_on("fix")
    assert times.take("fix", 60.0, 60.1) == [ON, ON]


def test_what_is_behind_was_no_pause():
    times = Times().run(0.0, 10.0)
    assert times.take("fix", 3.0) == [OFF]
    assert times.tick(60.0) == ()


def test_delays_of_the_first_messages_do_not_count():
    """The largest lead over the node's clock does: a first message may have been on its way."""
    times = Times()
    times.tick(5.0)
    times.take("fix", 0.0)
    for i in range(1, 40):
        times.take("fix", 0.1 * i)
        times.tick(5.0 + 0.02 * i)  # catches up
    assert times.tick(20.0) == ()
    assert times.take("fix", 20.0) == [ON]


def test_a_node_s_clock_that_is_set_is_followed():
    times = Times().run(0.0, 10.0)
    for i in range(20):  # an hour later by the node's clock alone
        times.tick(3610.0 + 0.1 * i)
        assert times.take("fix", 10.0 + 0.1 * i) == [ON]
    assert times.take("fix", 1000.0) == [OFF]
    assert times.tick(3612.1) == ()


def test_until_a_stamp_came_after_the_node_s_clock_was_set_leads_are_unknown():
    times = Times().run(0.0, 10.0)
    assert times.tick(-90.0) == ()
    assert times.take("fix", 60.0) == [OFF]
    assert times.tick(-90.0) == ("fix",)  # nothing speaks against it
    assert times.take("gimbal", 10.0) == [ON]
    assert times.take("gimbal", 60.0) == [OFF]
    assert times.tick(-90.0) == ("fix",)


def test_stamps_that_return_or_are_elsewhere_end_a_rival():
    times = Times().run(0.0, 10.0)
    assert times.take("fix", 500.0, 500.1, 700.0, 10.0, 10.1) == [OFF, OFF, ELSEWHERE, BACK, ON]
    assert times.clock.newest("fix") == ns(10.1)


def test_values_that_hold_may_be_stamped_long_ago():
    times = Times(held=("camera_info",))
    assert times.take("camera_info", 100.0, 0.0, 100.0, 103.0) == [ON, ON, ON, OFF]
    assert times.clock.apart_s("camera_info") == pytest.approx(3.0)


def begun_anew(times, off, names, images=2):
    """Return the decision after messages of some inputs, then images, moved."""
    for name in names:
        times.take(name, 10.0 + off)
        assert times.decision(name) is None
    for i in range(images):
        assert times.take("detections", 10.0 + off + 0.1 * i)[0] is OFF
    return times.decision("detections")


@pytest.mark.parametrize(
    ("names", "images", "anew"),
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
def test_most_needed_inputs_decide_whether_time_began_anew(names, images, anew, off):
    times = Times().run(0.0, 10.0, (*TELEMETRY, "attitude", "camera_info", "detections"))
    decision = begun_anew(times, off, names, images)
    assert (decision is not None) == anew
    if anew:
        assert decision.anew
        assert set(decision.moved) == {"detections", *names}
        assert decision.by_ns == pytest.approx(ns(off), abs=ns(0.3))


@pytest.mark.parametrize(("apart", "anew"), [(2.5, True), (3.5, False)])
def test_what_moved_otherwise_is_no_witness(apart, anew):
    times = Times(("fix",)).run(0.0, 10.0, ("fix", "detections"))
    times.take("fix", 110.0 + apart)
    times.take("detections", 110.0, 110.1)
    assert (times.decision("detections") is not None) == anew


@pytest.mark.parametrize(("seconds", "anew"), [(9.5, False), (10.5, True)])
def test_images_alone_are_followed_after_10_s(seconds, anew):
    times = Times().run(0.0, 10.0)
    times.run(10.0, 10.0 + seconds, TELEMETRY)
    times.take("detections", 110.0)
    for i in range(round(seconds * 10)):
        times.take("detections", 110.0 + 0.1 * i)
    assert (times.decision("detections") is not None) == anew


@pytest.mark.parametrize(("images", "anew"), [(3, False), (4, True)])
def test_without_other_inputs_four_images_decide(images, anew):
    times = Times(()).run(0.0, 10.0, ("detections",))
    times.take("detections", *(1000.0 + 0.1 * i for i in range(images)))
    assert (times.decision("detections") is not None) == anew


@pytest.mark.parametrize(("step", "anew"), [(-100.0, True), (-96.0, False), (-104.0, False)])
def test_the_node_s_clock_is_a_witness_where_it_steps_along(step, anew):
    times = Times().run(0.0, 10.0)
    times.tick(9.9 + step)
    times.take("detections", -90.0)
    decision = times.decision("detections")
    assert (decision is not None) == anew
    if anew:
        assert "clock" in decision.moved


def test_inputs_that_went_on_speak_against_the_node_s_clock():
    times = Times().run(0.0, 10.0)
    times.tick(-90.1)
    for name in TELEMETRY:
        times.take(name, 10.0)
    times.take("detections", -90.0)
    assert times.decision("detections") is None


def test_images_that_come_to_the_time_of_telemetry():
    times = Times().run(0.0, 10.0, TELEMETRY).run(9.0, 10.0, ("detections",), off=-500.0)
    times.take("detections", 10.0)
    assert times.decision("detections") is None
    times.take("detections", 10.1)
    decision = times.decision("detections")
    assert (set(decision.moved), set(decision.kept)) == ({"detections"}, set(TELEMETRY))
    times.clock.believe(decision)
    assert times.take("fix", 10.1, 500.0) == [ON, OFF]  # its line is still there
    assert times.take("detections", 10.2) == [ON]


def test_telemetry_that_comes_to_the_time_of_images():
    times = Times().run(0.0, 10.0, ("detections",)).run(9.0, 10.0, ("fix",), off=-500.0)
    times.take("fix", 10.0, 10.1)
    assert times.decision("fix") is None
    times.take("fix", 10.2)
    decision = times.decision("fix")
    assert decision == Decision(False, ("fix",))
    times.clock.believe(decision)
    assert times.take("fix", 10.2) == [ON]
    assert times.take("detections", 10.0) == [ON]


def test_telemetry_that_leaves_the_images_is_followed_after_10_s():
    times = Times().run(0.0, 10.0)
    times.take("fix", *(500.0 + 0.1 * i for i in range(100)))
    assert times.decision("fix") is None
    times.take("fix", 510.1)
    assert times.decision("fix") == Decision(False, ("fix",))


def test_a_wrong_first_stamp_is_outvoted_by_two():
    times = Times()
    times.take("fix", 500.0, 0.0)
    assert times.decision("fix") is None
    times.take("fix", 0.1)
    assert times.decision("fix") == Decision(False, ("fix",))
