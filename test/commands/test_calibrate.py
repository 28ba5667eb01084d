# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss calibrate`: from a bag to a parameter file that replay takes."""

from __future__ import annotations

import json

import pytest

from aerial_gnss_ros.adapters.parameter_files import read
from aerial_gnss_ros.cli import main
from aerial_gnss_ros.core.config import estimator_config
from aerial_gnss_ros.nodes.schemas import ESTIMATOR, SCHEMAS


def _run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


@pytest.fixture
def transit(tmp_path):
    bag = tmp_path / "bag"
    assert _run(
        "simulate", "-o", bag, "--flight", "transit", "--duration", "30", "--speed", "3", "--rate",
        "4", "--height", "20", "--robots", "2", "--robot-speed", "0", "--no-images", "--latency",
        "1.2", "--seed", "6",
    ) == 0  # fmt: skip
    return bag


def test_a_late_bag_becomes_parameters(transit, tmp_path, capsys):
    written = tmp_path / "calibration.yaml"
    capsys.readouterr()
    assert _run("calibrate", transit, "-o", written, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["corrections"]["latency"]["value"] == pytest.approx(1.2, abs=0.05)
    assert len(told["robots"]) == 2  # the second pass tells them apart
    config = estimator_config(read([written], SCHEMAS, "/drone1")[ESTIMATOR])
    assert config.camera.latency_s == pytest.approx(1.2, abs=0.05)
    for name, value in told["parameters"].items():
        group, key = name.split(".")
        assert getattr(getattr(config, group), key) == pytest.approx(value)
    assert _run("calibrate", transit, "-o", written) == 2  # never overwritten
    assert "exists already" in capsys.readouterr().err
