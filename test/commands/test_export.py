# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss export`: an export with its scores, and one sentence for each wrong input."""

from __future__ import annotations

import json

import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.simulation.dataset import DatasetConfig, generate

pytest.importorskip("onnx", reason="pip install '.[export]'")


def test_half_with_scores_beside_the_original(tmp_path, capsys):
    generate(tmp_path / "set", DatasetConfig({"test": 4}, size=(320, 320), seed=2024))
    made = tmp_path / "half.onnx"
    arguments = ["export", "aqua_yolo11n.onnx", "-o", str(made), "--precision", "fp16"]
    arguments += ["--score", str(tmp_path / "set"), "--backend", "onnxruntime", "--json"]
    assert cli.main(arguments) == 0
    first, half = json.loads(capsys.readouterr().out)
    assert first["images"] == half["images"] == 4
    assert first["map50"] > 0.5
    assert half["map50_95"] == pytest.approx(first["map50_95"], abs=0.005)
    assert first["centre_shift_p95_px"] == 0.0
    assert 0.0 < half["centre_shift_p95_px"] < 0.2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.onnx", "--precision", "fp16"], "none.onnx does not exist"),
        (["aqua_yolo11n.onnx"], "is an .onnx file already"),
        (["aqua_yolo11n.onnx", "--precision", "int8"], "int8 needs --calibration"),
        (["aqua_yolo11n.onnx", "--precision", "int8", "--calibration", "none"], "none does not"),
        (["aqua_yolo11n.onnx", "--precision", "int8", "--calibration", "."], "no calibration im"),
        (["aqua_yolo11n.onnx", "--precision", "fp16", "--score", "none"], "no images"),
        (["aqua_yolo11n.onnx", "--precision", "fp16", "--size", "640x640"], "--size is for"),
        (["aqua_yolo11n.onnx", "--precision", "fp16", "--calibration", "."], "only with --prec"),
        (["aqua_yolo11n.onnx", "--precision", "fp16", "--backend", "npu"], "invalid choice: 'npu'"),
        (["weights.pt"], "--allow-pickle"),
        (["notes.txt"], "neither"),
        (["text.onnx", "--precision", "fp16"], "not an ONNX model"),
        (["aqua_yolo11n.onnx", "--precision", "fp16", "-o", "made.txt"], "must end in .onnx"),
        (["aqua_yolo11n.onnx", "--precision", "fp16", "-o", "text.onnx"], "exists already"),
    ],
)
def test_wrong_input_is_one_sentence_and_leaves_nothing(
    tmp_path, monkeypatch, capsys, arguments, words
):
    monkeypatch.chdir(tmp_path)
    for name in ("weights.pt", "notes.txt", "text.onnx"):
        (tmp_path / name).write_text("something")
    before = sorted(tmp_path.iterdir())
    if "-o" not in arguments:
        arguments = [*arguments, "-o", "made.onnx"]
    assert cli.main(["export", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before
