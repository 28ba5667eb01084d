# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a latched topic keeps of a robot that is lost."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

from aerial_gnss_ros.adapters.departures import Departures
from aerial_gnss_ros.adapters.results import NO_FIX, UNKNOWN_LENGTH_M2, position_messages
from aerial_gnss_ros.core.values.estimates import FrameResult, State

sys.path.insert(0, str(Path(__file__).parent))

from one_robot import DATUM, ROBOT

ONE = replace(ROBOT, stamp_ns=5, last_seen_ns=5)

TWO = replace(ONE, robot_id="aqua_2", latitude=0.3)


def result(stamp_ns, *estimates):
    return FrameResult(stamp_ns, "camera", estimates, (), DATUM)


def test_a_lost_robot_has_one_last_message_that_claims_nothing():
    departures = Departures()
    first = result(5, ONE, TWO)
    assert departures.completed(first) is first
    second = departures.completed(result(9, ONE))
    assert [(one.robot_id, one.state) for one in second.estimates] == [
        ("aqua_1", State.CONFIRMED),
        ("aqua_2", State.LOST),
    ]
    assert departures.present == (ONE,)
    messages = {m.topic: m.fields for m in position_messages(second)}
    fix = messages["robots/aqua_2/fix"]
    assert fix["status"]["status"] == NO_FIX
    assert fix["header"]["stamp"] == {"sec": 0, "nanosec": 9}
    assert fix["latitude"] == math.degrees(TWO.latitude)
    assert fix["position_covariance"][0] == fix["position_covariance"][4] == UNKNOWN_LENGTH_M2
    for kind in ("geo_pose", "odom"):
        covariance = messages[f"robots/aqua_2/{kind}"]["pose"]["covariance"]
        assert covariance[0] == covariance[7] == UNKNOWN_LENGTH_M2
    twist = messages["robots/aqua_2/odom"]["twist"]
    assert twist["twist"]["linear"] == {"x": 0.0, "y": 0.0}
    assert twist["covariance"][0] == UNKNOWN_LENGTH_M2
    third = result(10, ONE)
    assert departures.completed(third) is third


def test_all_are_lost_where_the_estimator_began_anew():
    departures = Departures()
    departures.completed(result(5, ONE, TWO))
    ended = departures.completed(FrameResult(2, "", (), (), None))
    assert [one.state for one in ended.estimates] == [State.LOST, State.LOST]
    assert departures.present == ()
