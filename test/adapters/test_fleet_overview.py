# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is said of each drone of a fleet can be read by strict readers of JSON."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.adapters.fleet_overview import drones_text, fleet_overview_text
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.fleet.agreement import Agreement
from aerial_gnss_ros.core.fleet.clocks import ClockOffset
from aerial_gnss_ros.core.fleet.shore import Link
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.estimates import FrameResult


def no_constant(name):
    raise AssertionError(name)


def test_each_drone_is_told_and_what_is_not_known_is_null():
    report = SimpleNamespace(
        agreement=Agreement().ratio, shared=2, offset=np.array([0.5, -1.0]),
        offset_sigma=np.array([0.1, np.inf]), disagrees=True, fault="compass",
        clock=ClockOffset(0.125, math.nan),
    )  # fmt: skip
    known = Link("a", "north/a", EstimatorConfig(), delay_s=0.25)
    known.update = SimpleNamespace(report=report, names={"aqua_1": "aqua_3"})
    known.refused["flood"] = 3
    text = drones_text(7, [known, Link("b", "b", EstimatorConfig())])
    told = json.loads(text, parse_constant=no_constant)
    assert told["stamp_ns"] == 7
    first, second = told["drones"]
    assert math.isnan(report.agreement)
    assert first == {
        "drone": "a", "namespace": "north/a", "agreement": None, "shared_robots": 2,
        "offset_east_m": 0.5, "offset_north_m": -1.0, "sigma_east_m": 0.1, "sigma_north_m": None,
        "disagrees": True, "fault": "compass", "clock_ahead_s": 0.125, "clock_sigma_s": None,
        "delay_s": 0.25,
        "missing": 0, "lost": 0, "repeated": 0, "refused_flood": 3,
        "names": {"aqua_1": "aqua_3"},
    }  # fmt: skip
    assert (second["names"], second["delay_s"]) == ({}, None)
    assert (second["disagrees"], second["fault"]) == (False, "")


def test_the_page_gets_all_drones_with_what_they_show_and_the_fleets_names():
    lens = np.array([[500.0, 0.0, 320.0], [0.0, 500.0, 240.0], [0.0, 0.0, 1.0]])
    camera = CameraModel(640, 480, "plumb_bob", lens)
    links = []
    for name, height in (("a", 10.0), ("b", 20.0)):
        down = matrix_from_rpy(0.0, math.radians(90.0), 0.0)
        pose = CameraPose(5, 0.23, -1.04, height, height, down)
        link = Link(name, name, EstimatorConfig())
        link.seen = SimpleNamespace(stamp_ns=9, pose=pose, camera=camera, labels=("x", "", "y"))
        link.update = SimpleNamespace(names={"x": "aqua_7"})
        links.append(link)
    result = FrameResult(9, "camera", (), (), None, links[0].seen.pose)
    silent = Link("c", "c", EstimatorConfig())
    text = fleet_overview_text(result, 12, [*links, silent])
    fields = json.loads(text, parse_constant=no_constant)
    assert (fields["drone"], fields["footprint"], fields["now_ns"]) == (None, [], 12)
    assert [one["name"] for one in fields["drones"]] == ["a", "b"]
    assert [one["height_m"] for one in fields["drones"]] == [10.0, 20.0]
    assert [one["sees"] for one in fields["drones"]] == [["aqua_7"]] * 2
    size = [np.ptp(np.array(one["footprint"]), axis=0).max() for one in fields["drones"]]
    assert size[1] == pytest.approx(2.0 * size[0], rel=1e-3)
    assert fields["drones"][0]["stamp_ns"] == 9
