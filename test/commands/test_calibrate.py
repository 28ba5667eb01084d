# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss calibrate`: from a bag to a parameter file that replay takes."""

from __future__ import annotations

import json

import pytest

from aerial_gnss_ros.adapters.parameter_files import read
from aerial_gnss_ros.cli import main
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.nodes.schemas import ESTIMATOR, SCHEMAS


def _run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def _fly(bag, *arguments):
    assert _run(
        "simulate", "-o", bag, "--duration", "30", "--rate", "3", "--robots", "2", "--no-images",
        *arguments,
    ) == 0  # fmt: skip


def test_a_late_bag_becomes_parameters(tmp_path, capsys):
    bag, written = tmp_path / "bag", tmp_path / "calibration.yaml"
    _fly(
        bag, "--flight", "transit", "--speed", "3", "--height", "20", "--robot-speed", "0",
        "--latency", "1.2", "--seed", "6",
    )  # fmt: skip
    capsys.readouterr()
    assert _run("calibrate", bag, "-o", written, "--json") == 0
    reported = json.loads(capsys.readouterr().out)
    assert reported["corrections"]["latency"]["value"] == pytest.approx(1.2, abs=0.05)
    assert len(reported["robots"]) == 2
    config = estimator_config(read([written], SCHEMAS, "/drone1")[ESTIMATOR])
    assert config.camera.latency_s == pytest.approx(1.2, abs=0.05)
    for name, value in reported["parameters"].items():
        group, key = name.split(".")
        assert getattr(getattr(config, group), key) == pytest.approx(value)
    assert _run("calibrate", bag, "-o", written) == 2  # never overwritten
    assert "exists already" in capsys.readouterr().err


def test_boxes_that_do_not_fit_write_nothing(tmp_path, capsys):
    """Robots at 2.5 m/s are none: a sentence, status 1, no file."""
    bag, written = tmp_path / "bag", tmp_path / "calibration.yaml"
    _fly(bag, "--flight", "orbit", "--robot-speed", "2.5")
    capsys.readouterr()
    assert _run("calibrate", bag, "-o", written) == 1
    reported = capsys.readouterr().out
    assert "nothing is written" in reported
    assert "faster than they can: aqua" in reported
    assert "swam at" in reported
    assert not written.exists()
    assert not list(tmp_path.glob("*calibration*"))
