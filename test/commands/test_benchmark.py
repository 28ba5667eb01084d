# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss benchmark`: refusals in a sentence; a small run with real nodes and processes."""

from __future__ import annotations

import json
import runpy
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.cli import main

pytest.importorskip("rclpy", reason="ROS 2 is not installed")

MODEL = Path(__file__).parents[1] / "detection" / "synthetic_model.py"


@pytest.fixture
def bag(flight, tmp_path):
    """Write a hover whose images show one white robot."""

    def white(topic, msgtype, fields):
        if msgtype == "sensor_msgs/msg/Image":
            picture = np.zeros(flight.size[::-1], np.uint8)
            picture[232:248, 208:232] = 255
            fields = fields | {"data": picture.ravel()}
        return topic, msgtype, fields

    return flight.write(tmp_path / "flight", images=True, change=white)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--frames", "3"], "--frames must lie within 10 to 100000, not 3"),
        (["--robots", "1", "50"], "--robots must lie within 1 to 20, not 50"),
        (["--starts", "0"], "--starts must lie within 1 to 100, not 0"),
        (["--rate", "0"], "--rate must lie within 1 to 240, not 0"),
        (["--model", "absent.onnx"], "absent.onnx"),
        (["--backend", "abacus"], "backend must be one of"),
        (["--bag", "absent_bag"], "absent_bag"),
        (["--page", "absent.md"], "has no lines <!-- benchmark -->"),
        (["--params", "absent.yaml"], "absent.yaml"),
        (["--compare", "x/absent.pt"], "--compare x/absent.pt does not exist"),
    ],
)
def test_what_cannot_be_measured_is_refused(arguments, sentence, capsys, bag, tmp_path):
    given = [word.format(bag=bag) for word in arguments]
    output = tmp_path / "out"
    assert main(["benchmark", *given, "-o", str(output)]) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert "Traceback" not in error
    assert not output.exists()


def test_a_pickle_to_compare_with_is_refused_before_anything_is_measured(capsys, tmp_path):
    pickle = tmp_path / "a.pt"
    pickle.touch()
    assert main(["benchmark", "--compare", str(pickle)]) == 2
    assert "add --allow-pickle if you trust it" in capsys.readouterr().err


def test_a_bag_without_images_is_refused(capsys, flight, tmp_path):
    assert main(["benchmark", "--bag", str(flight.write(tmp_path / "boxes"))]) == 2
    assert "no images on /camera/image_raw" in capsys.readouterr().err


@pytest.mark.slow
def test_a_short_run_through_both_ways(capsys, bag, tmp_path):
    model = runpy.run_path(str(MODEL))["white_box_model"](tmp_path / "white.onnx")
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- benchmark -->\nold\n<!-- end of benchmark -->\nafter\n")
    status = main(
        [
            "benchmark", "--bag", str(bag), "--frames", "20", "--rate", "10",
            "--search", "roi", "--starts", "2", "--model", str(model), "--backend", "onnxruntime",
            "-o", str(tmp_path / "out"), "--page", str(page), "--json",
        ]
    )  # fmt: skip
    assert status == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures == json.loads((tmp_path / "out" / "benchmark.json").read_text())
    (run,) = figures["runs"]
    assert run["one_process"]["images"] == 20
    assert run["one_process"]["positions"] > 0
    stages = {"decode", "infer", "publish boxes", "estimate", "publish"}
    assert set(run["one_process"]["stages_ms"]) >= stages
    nodes = run["nodes"]
    assert nodes["images_offered"] == 20
    assert nodes["images_processed"] > 0
    assert nodes["stamp_to_position_ms"]["median"] > 0.0
    assert nodes["stages_ms"]["wait"]["median"] >= 0.0
    assert nodes["peak_memory_mb"] > 50.0
    assert len(nodes["starts_s"]) == 2
    assert nodes["starts_s"][0] > 0.0
    text = page.read_text()
    assert text.startswith("before\n<!-- benchmark -->\nMeasured")
    assert text.endswith("<!-- end of benchmark -->\nafter\n")
    assert "ultralytics: not requested" in text
