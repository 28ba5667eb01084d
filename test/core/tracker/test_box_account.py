# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every box of every image is used or refused, once, whatever becomes of its track."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.tracker.box_account import TUNING as BOX_ACCOUNT
from aerial_gnss_ros.core.tracker.box_account import BoxAccount, complaint
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.rejection import Cause, Reason

pytestmark = pytest.mark.flights

STILL = {"a": lambda _t: (-3.0, 18.0), "b": lambda _t: (3.0, 18.0)}


def image(stamp_ns, *columns):
    """Return an image with boxes in these columns, px."""
    centers = np.column_stack([columns, np.zeros(len(columns))])
    sizes, scores = np.ones_like(centers), np.ones(len(columns))
    return DetectionFrame(stamp_ns, "camera", centers, sizes, scores, ("aqua",) * len(columns))


def missed_often(name, t):
    return name == "b" and round(10 * t) % 25 > 1  # two images of 25


def dives(_name, t):
    return 3.0 < t < 6.0


FLIGHTS = {
    "still": {},
    "clutter": {"clutter": 2.0},
    "heavy clutter": {"clutter": 12.0, "missed": 0.3},
    "often missed": {"hidden": missed_often},
    "dives": {"hidden": dives, "clutter": 0.3},
    "crossing": {
        "robots": {"a": lambda t: (-2.0 + 0.5 * t, 18.0), "b": lambda t: (2.0 - 0.5 * t, 18.1)},
        "pixel_sigma": 2.0,
    },
    "spinning compass": {"rpy_deg": lambda t: (0.0, 60.0, 90.0 + max(0.0, 90.0 * (t - 2.0)))},
    "too fast": {"robots": {"a": lambda t: (-8.0 + 5.0 * t, 18.0)}},
    "compass turns": {
        "rpy_deg": lambda t: (0.0, 60.0, 90.0 + (30.0 * math.sin(3.0 * t) if t > 3.0 else 0.0)),
        "clutter": 0.5,
    },
}


def flown(sea, changes, values=None, images=10, duration=7.0):
    world = sea.World(**{"robots": STILL, "pixel_sigma": 1.0, **changes})
    seen = Counter()
    frame = world.frame

    def counted(t):
        found = frame(t)
        seen[found.stamp_ns] += len(found)
        return found

    world.frame = counted
    world.pose = sea.World().pose  # what changes is what is measured of it
    engine = sea.estimator(values)
    results = sea.play(engine, world, duration, images=images)
    return engine, results, seen


@pytest.mark.parametrize("name", FLIGHTS)
def test_boxes_are_used_or_refused_and_never_twice(sea, name):
    engine, results, seen = flown(sea, FLIGHTS[name])
    refused = Counter()
    for result in results:
        assert all(one.stamp_ns == result.stamp_ns for one in result.rejections)
        assert all(one.stamp_ns <= result.stamp_ns for one in result.late)
        assert {one.reason for one in result.late} <= {Reason.UNCONFIRMED}
        refused.update(one.stamp_ns for one in (*result.rejections, *result.late))
    refused.update(one.stamp_ns for one in engine.ending)
    used = sum(result.used for result in results)
    assert engine.boxes == sum(seen.values()) > 0
    assert engine.used == used
    assert engine.counts.total() == refused.total()
    assert used + refused.total() == engine.boxes
    assert engine.counts[Reason.UNCONFIRMED] == engine.causes.total()
    assert all(count <= seen[stamp] for stamp, count in refused.items())


def test_boxes_before_confirmation_count_as_used(sea):
    engine, results, _ = flown(sea, {})
    assert engine.used == engine.boxes
    assert not engine.counts
    assert [result.used for result in results[:4]] == [0, 0, 6, 2]


def test_a_box_that_is_never_seen_again_is_refused_with_its_own_stamp_and_pixel(sea):
    world = sea.World(robots=STILL)
    frame = world.frame
    world.frame = lambda t: (
        frame(t)
        if abs(t - 1.0) > 0.01
        else sea.boxes(1.0, [[100.0, 600.0], *frame(t).centers.tolist()])
    )
    engine = sea.estimator()
    results = sea.play(engine, world, 5.0, images=10)
    (late,) = [one for result in results for one in result.late]
    assert (late.stamp_ns, late.u_px, late.v_px) == (sea.stamp(1.0), 100.0, 600.0)
    assert (late.reason, late.cause) == (Reason.UNCONFIRMED, Cause.TOO_FEW_IMAGES)
    assert [result.stamp_ns for result in results if result.late] == [sea.stamp(3.1)]


@pytest.mark.parametrize(
    ("changes", "images", "cause"),
    [
        ({"robots": {"a": lambda _t: (-3.0, 18.0)}, "hidden": lambda _n, t: t > 0.15}, 10,
         Cause.TOO_FEW_IMAGES),
        ({"robots": {"a": lambda _t: (-3.0, 18.0)}}, 0.25, Cause.IMAGES_TOO_SELDOM),
        ({"robots": {"a": lambda t: (-8.0 + 2.7 * t, 18.0)}}, 5, Cause.TOO_FAST),
        ({"robots": {"a": lambda t: (-8.0 + 6.0 * t, 18.0)}}, 2, Cause.OUT_OF_GATE),
        ({"robots": {"a": lambda _t: (-3.0, 18.0)},
          "hidden": lambda _n, t: round(10 * t) % 3 > 0}, 10, Cause.CLUTTER),
    ],
)  # fmt: skip
def test_the_likely_cause_is_reported(sea, changes, images, cause):
    engine, _, _ = flown(sea, {**changes, "pixel_sigma": 0.0}, images=images, duration=12.0)
    assert engine.causes.most_common(1)[0][0] is cause, engine.causes


def test_a_recording_that_ends_leaves_nothing_undecided(sea):
    engine, results, _ = flown(sea, {}, duration=0.1)
    assert [result.late for result in results] == [(), ()]
    assert [one.cause for one in engine.ending] == [Cause.CUT_SHORT] * 4


def test_a_restart_of_time_decides_what_was_pending(sea):
    engine, world = sea.estimator(), sea.World(robots=STILL)
    sea.play(engine, world, 0.1, begin=100.0, images=10, until_flush=False)
    sea.play(engine, world, 1.0, begin=0.0, images=10)
    assert engine.causes == {Cause.CUT_SHORT: 4}
    assert engine.boxes == engine.used + engine.counts.total()


def test_a_box_that_would_make_a_robot_too_fast_is_refused_as_such(sea):
    jumps = {"a": lambda t: (-3.0, 18.0) if t < 4.0 else (-3.0 + 3.2 * (t - 4.0), 18.0)}
    _, results, _ = flown(sea, {"robots": jumps, "pixel_sigma": 0.0})
    refused = [one for result in results for one in result.rejections]
    assert Reason.TOO_FAST in {one.reason for one in refused}
    assert all(one.cause is None for one in refused)


def test_most_boxes_that_come_to_nothing_are_reported_with_the_likely_cause():
    refused, causes = {Reason.GATED: 3, Reason.UNCONFIRMED: 27}, {Cause.OUT_OF_GATE: 27}
    words = complaint(10, refused, causes)
    assert "30 of 40 boxes updated no robot, 27 as unconfirmed, mostly out_of_gate" in words
    assert "camera.latency_s" in words
    assert complaint(31, refused, causes) == ""
    assert complaint(0, {Reason.NO_FIX: 19}, {}) == ""
    assert complaint(0, {Reason.NO_FIX: 20}, {}).endswith(Reason.NO_FIX.meaning)
    assert complaint(0, {}, {}) == ""


def test_what_is_pending_with_a_track_is_bounded():
    account, track = BoxAccount(), Track("aqua", 0, 0)
    for i in range(BOX_ACCOUNT.most_pending + 5):
        account.note([track], {0: 0}, image(i, float(i)))
    settled = account.drain()
    assert [one.stamp_ns for one in settled.refused] == [0, 1, 2, 3, 4]
    track.robot_id = "aqua_1"
    account.confirm([track])
    assert account.drain().used == BOX_ACCOUNT.most_pending
    assert account.drain().used == 0


def test_a_folded_track_hands_over_its_boxes():
    account, one, other = BoxAccount(), Track("aqua", 0, 0), Track("aqua", 0, 0)
    account.note([one, other], {0: 0, 1: 1}, image(1, 0.0, 1.0))
    one.absorb(other)
    account.end([other], 3, 10)
    one.robot_id = "aqua_1"
    account.confirm([one, other])
    settled = account.drain()
    assert (settled.used, settled.refused) == (2, ())
