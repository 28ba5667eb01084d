# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A simulated recording says that its altitudes are above the ellipsoid."""

from __future__ import annotations

import json

import pytest

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.stated_datum import with_stated_datum
from aerial_gnss_ros.bags.writer import BagWriter
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config


@pytest.mark.parametrize(
    ("text", "datum"),
    [
        (json.dumps({"altitude_datum": "ellipsoid"}), "ellipsoid"),
        (json.dumps({"altitude_datum": "moon"}), "unknown"),
        ("{}", "unknown"),
        ("[1, 2", "unknown"),
        ("7", "unknown"),
        (None, "unknown"),
    ],
)
def test_what_the_recording_states_holds_where_nobody_says_anything_else(tmp_path, text, datum):
    with BagWriter(tmp_path / "bag") as bag:
        bag.write("height", "std_msgs/msg/Float64", 1, {"data": 1.0})
        if text is not None:
            bag.write("d1/truth/scenario", "std_msgs/msg/String", 1, {"data": text})
    with open_bag([tmp_path / "bag"]) as bag:
        assert with_stated_datum(EstimatorConfig(), bag).fix.altitude_datum == datum
        given = estimator_config({"fix.altitude_datum": "amsl"})
        assert with_stated_datum(given, bag) is given
