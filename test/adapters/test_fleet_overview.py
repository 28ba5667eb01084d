# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is said of each drone of a fleet can be read by strict readers of JSON."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import numpy as np

from aerial_gnss_ros.adapters.fleet_overview import drones_text
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.fleet.agreement import Agreement
from aerial_gnss_ros.core.fleet.shore import Link


def no_constant(name):
    raise AssertionError(name)


def test_each_drone_is_told_and_what_is_not_known_is_null():
    report = SimpleNamespace(
        agreement=Agreement().ratio, shared=2, offset=np.array([0.5, -1.0]),
        offset_sigma=np.array([0.1, np.inf]), disagrees=True, fault="compass",
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
        "disagrees": True, "fault": "compass", "delay_s": 0.25,
        "missing": 0, "lost": 0, "repeated": 0, "refused_flood": 3,
        "names": {"aqua_1": "aqua_3"},
    }  # fmt: skip
    assert (second["names"], second["delay_s"]) == ({}, None)
    assert (second["disagrees"], second["fault"]) == (False, "")
