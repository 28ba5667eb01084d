# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Each thing is said once, and a reference that is not used only after a while."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.references.candidates import Candidate, Motion
from aerial_gnss_ros.core.references.hypotheses import Hypothesis
from aerial_gnss_ros.core.references.position_law import PositionLaw
from aerial_gnss_ros.core.references.reference_report import TUNING, ReferenceReport
from aerial_gnss_ros.core.values.events import Events, WarningText

LAW = PositionLaw(np.array([0]), np.zeros(COUNT + 4), np.eye(COUNT + 4))
TRACKS = [Track("beacon", 0, 5, robot_id="beacon_1")]
PIER = Candidate("pier", np.array([6.0, 8.0]), 3.0 * np.eye(2), (0,), False)


def said(log, report, seconds, found, links=None):
    for t in seconds:
        report.update(round(t * 1e9), [PIER], found, links or {}, LAW, TRACKS)
    return log.drain()


def test_one_that_is_not_used_is_said_once_after_a_while():
    log = Events()
    report, none = ReferenceReport(log), [Hypothesis({}, 1.0)]
    assert said(log, report, [0.0, TUNING.said_after_s - 0.1], none) == []
    (sentence,) = said(log, report, [2.0, 3.0, 60.0], none)
    assert isinstance(sentence, WarningText)
    assert sentence.startswith(
        "Reference pier is not used: beacon_1 is seen 10.0 m from where it should be (one sigma "
        "without references 2.0 m), which contradicts the receiver; check the position"
    )


def test_what_contradicts_it_is_named():
    log = Events()
    report, none = ReferenceReport(log), [Hypothesis({}, 1.0)]
    (sentence,) = said(log, report, [0.0, 5.0], none, {"post": "post_1"})
    assert "contradicts post;" in sentence
    log = Events()
    either = [Hypothesis({"pier": 0}, 0.5), Hypothesis({"post": 1}, 0.5)]
    (sentence,) = said(log, ReferenceReport(log), [0.0, 5.0], either)
    assert "contradicts the receiver or another reference;" in sentence


def test_one_of_several_alike_is_said_to_be_that():
    log = Events()
    either = [Hypothesis({"pier": 0}, 0.5), Hypothesis({"pier": 1}, 0.5)]
    (sentence,) = said(log, ReferenceReport(log), [0.0, 5.0], either)
    assert sentence.endswith("it may be one of several of its class; give it a class of its own.")


def test_one_that_is_alone_but_far_off_is_not_said_to_be_one_of_several():
    log = Events()
    rather = [Hypothesis({"pier": 0}, 0.98), Hypothesis({}, 0.02)]
    (sentence,) = said(log, ReferenceReport(log), [0.0, 5.0], rather)
    assert sentence.endswith("references 2.0 m); it is used once that is more certain.")


def refused(motion, found):
    """Return what is said of a reference by the motion of its track."""
    log, moved = Events(), replace(PIER, motions={0: motion})
    report = ReferenceReport(log)
    for t in (0, 3):
        report.update(t * 10**9, [moved], found, {}, LAW, TRACKS)
    (sentence,) = log.drain()
    return sentence


@pytest.mark.parametrize(
    ("nats", "adrift", "metres", "words"),
    [
        (0.0, 5.4, 4.5, "has moved by 4.5 m"),
        (0.0, 5.2, 4.5, "is seen 10.0"),
        (-3.0, 2.4, 4.5, "has moved by 4.5 m"),
        (-3.0, 2.2, 4.5, "is seen 10.0"),
        (8.0, 8.0, 4.5, "is seen 10.0"),
        (0.0, 9.0, 0.0, "is seen 10.0"),
    ],
)
def test_one_that_has_moved_is_said_to_have(nats, adrift, metres, words):
    """One in ten is adrift: the odds that it is to that it stays are 20 at log 200 = 5.3."""
    found = refused(Motion(nats, adrift, metres), [Hypothesis({}, 1.0)])
    assert f"beacon_1 {words}" in found


def test_one_of_several_alike_is_not_said_to_have_moved():
    """Which of them it is comes first: it may be one that has not."""
    either = [Hypothesis({"pier": 0}, 0.5), Hypothesis({"pier": 1}, 0.5)]
    found = refused(Motion(0.0, 9.0, 4.5), either)
    assert found.endswith("it may be one of several of its class; give it a class of its own.")


def test_one_whose_track_is_estimated_apart_is_said_to_be_that():
    """The filter estimates many robots in groups; references of one group are weighed together."""
    log = Events()
    report = ReferenceReport(log)
    for t in (0, 3):
        report.update(t * 10**9, [replace(PIER, rows=())], [Hypothesis({}, 1.0)], {}, LAW, TRACKS)
    assert log.drain() == [
        "Reference pier is not used: its track is estimated apart from those of other references."
    ]


def test_one_that_is_set_aside_is_said_at_once_and_when_it_is_taken_up_again():
    log = Events()
    report, used = ReferenceReport(log), {"pier": "beacon_1"}
    rather, right = ([Hypothesis({"pier": 0}, p), Hypothesis({}, 1.0 - p)] for p in (0.94, 1.0))
    assert len(said(log, report, [0.0], right, used)) == 1
    (sentence,) = said(log, report, [0.2, 0.4], rather)
    assert sentence.startswith("Reference pier is not used: beacon_1 is seen 10.0 m from where")
    (sentence,) = said(log, report, [0.6, 0.8], right, used)
    assert sentence == "Reference pier is beacon_1: positions refer to it."


def test_one_that_is_used_is_said_once_and_again_after_a_pause():
    log = Events()
    report, used = ReferenceReport(log), {"pier": "beacon_1"}
    found = [Hypothesis({"pier": 0}, 1.0)]
    expected = "Reference pier is beacon_1: positions refer to it."
    assert said(log, report, [0.0, 1.0], found, used) == [expected]
    assert len(said(log, report, [2.0, 5.0], [Hypothesis({}, 1.0)])) == 1
    assert said(log, report, [6.0, 7.0], found, used) == [expected]
