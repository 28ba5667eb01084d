# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A fix whose latency nobody states is found out in flight; one in time changes no position."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.values.estimates import State

pytestmark = pytest.mark.flights

STATED = {"noise.gnss_offset_m": 0.02, "noise.robot_acceleration": 0.01}
FALSE = {"fix.find_latency": False}
ROBOTS = {"a": lambda _t: (2.0, 18.0), "b": lambda _t: (-3.0, 22.0), "c": lambda _t: (6.0, 24.0)}


def to_and_fro(t):
    """A drone that flies back and forth at up to 4 m/s."""
    return 8.0 * math.sin(0.5 * t), 0.0, 30.0


def swaying(t):
    """A camera that turns as drones do: 3 deg either way in 4 s."""
    return 0.0, 60.0, 90.0 + 3.0 * math.sin(1.6 * t)


def steady(_t):
    return 0.0, 60.0, 90.0


def world(sea, fix_late_s=0.0, images_late_s=0.0, drone=to_and_fro, rpy_deg=swaying):
    """A world whose fixes, or images, stamped t are of an earlier time."""
    given = {"robots": ROBOTS, "pixel_sigma": 2.0}
    found = sea.World(drone=drone, rpy_deg=rpy_deg, **given)
    late = sea.World(drone=lambda t: drone(t - fix_late_s), rpy_deg=rpy_deg, **given)
    seen = sea.World(
        drone=lambda t: drone(t - images_late_s), rpy_deg=lambda t: rpy_deg(t - images_late_s),
        **given,
    )  # fmt: skip
    found.fix, found.frame = late.fix, seen.frame
    return found


def found_s(engine):
    """Latency that events state, s; None where they state none."""
    told = [str(one) for one in engine.events if "later than fix.latency_s" in str(one)]
    return float(told[-1].split()[3]) if told else None


def worst(results, from_s):
    """Largest error of a confirmed robot from a time on, m, and in its own sigmas."""
    truth = np.array([place(0.0) for place in ROBOTS.values()])
    found = [
        (one.position - truth[np.argmin(np.linalg.norm(truth - one.position, axis=1))], one)
        for result in results if (result.stamp_ns - results[0].stamp_ns) * 1e-9 > from_s
        for one in result.estimates if one.state is State.CONFIRMED
    ]  # fmt: skip
    sigmas = [math.sqrt(d @ np.linalg.solve(one.covariance[:2, :2], d)) for d, one in found]
    return max(float(np.linalg.norm(d)) for d, _ in found), max(sigmas)


@pytest.mark.parametrize("late_s", [0.3, -0.25])
def test_a_late_fix_is_found_and_corrected(sea, late_s):
    errors, names = {}, {}
    for stated in (STATED, STATED | FALSE):
        engine = sea.estimator(stated)
        results = sea.play(engine, world(sea, late_s), 30.0)
        errors[len(stated)] = worst(results, 22.0)[0]
        names[len(stated)] = {one.robot_id for result in results for one in result.estimates}
        found = found_s(engine)
        assert (found is None) is ("fix.find_latency" in stated)
        assert found is None or found == pytest.approx(late_s, abs=0.05)
    assert errors[2] < 0.35
    assert errors[3] > 2.0 * errors[2]
    assert names[2] == {"aqua_1", "aqua_2", "aqua_3"}  # no robot gets a new label


def test_a_fix_in_time_changes_no_position(sea):
    """And no covariance either, once images have ruled other latencies out."""
    flown = []
    for stated in (STATED, STATED | FALSE):
        results = sea.play(sea.estimator(stated), world(sea), 30.0)
        flown.append([(one.robot_id, one.position, np.trace(one.covariance[:2, :2]))
                      for result in results for one in result.estimates])  # fmt: skip
    wider = np.array([a[2] - b[2] for a, b in zip(*flown, strict=True)])
    for a, b in zip(*flown, strict=True):
        assert a[0] == b[0]
        np.testing.assert_array_equal(a[1], b[1])
    assert wider.max() > 0.01
    assert abs(wider[-1]) < 1e-12


def test_a_straight_flight_tells_nothing_and_covariances_say_so(sea):
    """At 4 m/s with one chance in ten of another latency, 0.18 s in the root mean square."""
    straight = lambda t: (4.0 * t - 60.0, 0.0, 30.0)  # noqa: E731
    ahead = {name: (lambda t, p=place: (4.0 * t - 60.0 + p(t)[0], p(t)[1]))
             for name, place in ROBOTS.items()}  # fmt: skip
    wide = {}
    for stated in (STATED, STATED | FALSE):
        one = world(sea, drone=straight, rpy_deg=steady)
        one.robots = ahead
        one.frame = sea.World(drone=straight, rpy_deg=steady, robots=ahead).frame
        engine = sea.estimator(stated | {"tracks.max_speed": 10.0})
        results = sea.play(engine, one, 20.0)
        assert found_s(engine) is None
        wide[len(stated)] = [e.covariance[:2, :2] for e in results[-1].estimates]
    for told, untold in zip(wide[3], wide[2], strict=True):
        more = untold - told
        assert 0.1**2 < more[0, 0] < 0.3**2
        assert abs(more[1, 1]) < 1e-6


def test_a_turn_after_a_minute_of_an_even_circle_still_tells(sea):
    """Around the circle images tell nothing; the drone slows down at 70 s, and flies back."""
    rate, back_s, sway = 2.0 * math.pi / 40.0, 70.0, 0.5

    def angle(t):
        after = max(0.0, t - back_s)
        return rate * min(t, back_s) + rate / sway * math.sin(sway * after)

    def around(t):
        return 20.0 * math.cos(angle(t)), 20.0 + 20.0 * math.sin(angle(t)), 30.0

    inward = lambda t: (0.0, 56.0, math.degrees(angle(t)) + 180.0)  # noqa: E731
    engine = sea.estimator(STATED)
    one = world(sea, 0.3, drone=around, rpy_deg=inward)
    sea.play(engine, one, back_s, until_flush=False)
    assert found_s(engine) is None
    sea.play(engine, one, 25.0, begin=back_s + 0.2)
    assert found_s(engine) == pytest.approx(0.3, abs=0.08)


@pytest.mark.parametrize("off_deg", [-3.2, 3.2])
def test_a_compass_off_by_two_sigmas_is_no_late_fix(sea, off_deg):
    """Over robots that are stated to stay, an even circle shows both alike."""
    rate = 2.0 * math.pi / 30.0
    one = sea.World(
        robots=ROBOTS, pixel_sigma=2.0, rpy_bias_deg=(0.0, 0.0, off_deg),
        drone=lambda t: (28.0 * math.cos(rate * t), 20.0 + 28.0 * math.sin(rate * t), 30.0),
        rpy_deg=lambda t: (0.0, 47.0, math.degrees(rate * t) + 180.0),
    )  # fmt: skip
    still = {"noise.robot_acceleration": 0.0, "tracks.max_speed": 0.01}
    engine = sea.estimator(STATED | still)
    results = sea.play(engine, one, 60.0)
    assert found_s(engine) is None
    assert worst(results, 20.0)[1] < 4.0


@pytest.mark.parametrize(("late_s", "rpy_deg"), [(0.3, swaying), (0.3, steady), (0.9, steady)])
def test_late_images_are_no_late_fix(sea, late_s, rpy_deg):
    """Where the camera does not turn they move it likewise; images are late more often."""
    engine = sea.estimator(STATED)
    sea.play(engine, world(sea, images_late_s=late_s, rpy_deg=rpy_deg), 20.0)
    assert found_s(engine) is None


def test_boxes_that_are_refused_do_not_shift_the_labels_of_others(sea):
    """The last images are taken in again by their boxes' numbers, of those that were used."""
    one = world(sea, 0.3)
    plain = one.frame

    def with_low_score(t):
        frame = plain(t)
        low = sea.boxes(t, [[5.0, 5.0], *frame.centers])
        return replace(low, scores=np.array([0.01, *frame.scores]))

    one.frame = with_low_score
    engine = sea.estimator(STATED | {"detections.min_score": 0.1})
    results = sea.play(engine, one, 30.0)
    assert found_s(engine) is not None
    assert {e.robot_id for result in results for e in result.estimates} == {
        "aqua_1", "aqua_2", "aqua_3",
    }  # fmt: skip
    assert worst(results, 22.0)[0] < 0.25
