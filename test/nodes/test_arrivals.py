# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rates, ages and silence; and the newest item between two threads."""

from __future__ import annotations

import threading

from aerial_gnss_ros.nodes.arrivals import Arrivals
from aerial_gnss_ros.nodes.inputs import ALWAYS, ONCE, OPTIONAL, Input, mismatch
from aerial_gnss_ros.nodes.newest import Newest

SECOND = 10**9


def test_rate_and_age():
    arrivals = Arrivals(0)
    assert arrivals.age_s(3 * SECOND) is None
    for step in range(101):
        arrivals.record(step * SECOND // 20)
    assert arrivals.rate(5 * SECOND) == 20.0
    assert arrivals.age_s(6 * SECOND) == 1.0
    assert arrivals.rate(60 * SECOND) == 0.0


def test_silence_is_reported_once_and_so_is_its_end():
    arrivals = Arrivals(0)
    reported = [arrivals.fell_silent(step * SECOND) for step in range(8)]
    assert reported == [False] * 5 + [True] + [False] * 2
    assert arrivals.record(8 * SECOND) == 8.0
    assert arrivals.record(9 * SECOND) is None
    assert not arrivals.fell_silent(13 * SECOND)
    assert arrivals.fell_silent(14 * SECOND)


def test_only_what_is_needed_is_missed():
    def missed(expected, count):
        arrivals = Arrivals(0)
        for _ in range(count):
            arrivals.record(SECOND)
        return Input("fix", "/fix", "a/msg/A", expected, "", arrivals).missed

    assert [missed(expected, 0) for expected in (ALWAYS, ONCE, OPTIONAL)] == [True, True, False]
    assert [missed(expected, 1) for expected in (ALWAYS, ONCE, OPTIONAL)] == [True, False, False]


def test_sentences_name_topic_publishers_and_remedy():
    source = Input("fix", "/d/fix", "sensor_msgs/msg/NavSatFix", ALWAYS, "off?", Arrivals(0))
    assert source.silence([]) == (
        "no fix for 5 s on /d/fix (publishers: 0): start its publisher, or remap /d/fix"
    )
    assert source.silence(["sensor_msgs/msg/NavSatFix"]).endswith("(publishers: 1): off?")
    assert "std_msgs/msg/String is published there instead of sensor_msgs/msg/NavSatFix" in (
        source.silence(["std_msgs/msg/String"])
    )
    said = mismatch("/detections", "publisher", "reliability", "reliable")
    assert "asks for reliable; set the publisher's reliability to reliable" in said


def test_the_newest_wins_and_dropped_ones_are_counted():
    newest = Newest()
    for item in (1, 2, 3):
        newest.put(item)
    assert (newest.pop(), newest.dropped) == (3, 2)
    taken = []
    reader = threading.Thread(target=lambda: taken.append(newest.pop()))
    reader.start()
    newest.close()
    reader.join(timeout=90.0)
    newest.put(4)
    assert taken == [None]
    assert newest.dropped == 2
