# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a second look learns from, how much it counts, and a training from labelled images."""

from __future__ import annotations

import sys
from dataclasses import fields
from pathlib import Path

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.second_look_terms import ODDS_UNIT, Terms
from aerial_gnss_ros.training.proposals import Proposals, joined, judged
from aerial_gnss_ros.training.second_look import main
from aerial_gnss_ros.training.share import Share

sys.path.insert(0, str(Path(__file__).parent))

from scored import truth_of

SHIPPED = Path(__file__).parents[2] / "models/aqua_yolo11n_second_look.onnx"


def test_what_counts_as_a_robot():
    robot = (0.0, 0.0, 20.0, 20.0)
    table = [
        (robot, True, 1.0),
        ((10.0, 0.0, 20.0, 20.0), True, 1.0),  # half of it: IoU 0.5
        ((11.0, 0.0, 20.0, 20.0), False, 0.3),  # 0.45: nearly
        ((8.0, 8.0, 12.0, 12.0), False, 0.5),  # 0.04, but on it: a part
        ((40.0, 0.0, 60.0, 20.0), False, 1.0),
    ]
    is_robot, weights = judged(np.array([row[0] for row in table]), truth_of(robot))
    assert is_robot.tolist() == [row[1] for row in table]
    np.testing.assert_allclose(weights, [row[2] for row in table])
    is_robot, weights = judged(np.array([robot]), truth_of())
    assert (is_robot.tolist(), weights.tolist()) == ([False], [1.0])


@pytest.fixture
def crosses():
    """Robots are crosses, everything else is squares; a detector would not know them apart."""
    rng = np.random.default_rng(3)
    views = np.full((400, 80, 80, 6), 60, np.uint8) + rng.integers(
        0, 20, (400, 80, 80, 6), np.uint8
    )
    is_robot = rng.random(400) < 0.5
    for view, cross in zip(views, is_robot, strict=True):
        view[24:56, 36:44] = view[36:44, 24:56] = 200
        if not cross:
            view[24:56, 24:56] = 200
    return Proposals(
        views, np.zeros((400, 3), np.float32), np.full(400, 0.5), is_robot, np.ones(400)
    )


@pytest.mark.ultralytics
@pytest.mark.parametrize(
    ("capabilities", "multiplies"),
    [
        ({"avx512_bf16": True, "amx_bf16": False}, True),
        ({"avx512_bf16": False, "amx_bf16": True}, True),
        ({"avx512_f": True, "avx512_bf16": False}, False),
        ({}, False),
    ],
)
def test_it_learns_in_16_bits_where_the_processor_multiplies_them(capabilities, multiplies):
    pytest.importorskip("torch", reason="needs the extra [ultralytics]")
    from aerial_gnss_ros.training.second_look_network_fit import multiplies_bfloat16

    assert multiplies_bfloat16(capabilities) is multiplies


def test_joined_and_times(crosses):
    both = joined([crosses, crosses.times(3.0)])
    assert len(both) == 800
    assert both.weights[[0, 799]].tolist() == [1.0, 3.0]


@pytest.mark.ultralytics
def test_it_learns_what_the_detector_does_not_know(tmp_path, crosses):
    pytest.importorskip("torch", reason="needs the extra [ultralytics]")
    from aerial_gnss_ros.training.second_look_network import write
    from aerial_gnss_ros.training.second_look_network_fit import fit
    from aerial_gnss_ros.training.second_look_network_pretrained import read

    learnt, kept = (
        Proposals(*(getattr(crosses, one.name)[part] for one in fields(Proposals)))
        for part in (slice(300), slice(300, None))
    )
    network = fit(learnt, Terms(), 40, 1, read(SHIPPED), threads=1, batch=32)
    path = tmp_path / "look.onnx"
    write(network, Terms(), Share(), path)
    inner = kept.views[:, 8:72, 8:72]  # as large as a look
    traits = np.zeros((len(kept), 3), np.float32)
    traits[:, 0] = np.where(kept.is_robot, -0.2, 0.2)  # the detector knows it the wrong way round
    alone = SecondLook(path, 1).run(inner, traits)
    assert np.quantile(alone[kept.is_robot], 0.1) > 0.6
    assert np.quantile(alone[~kept.is_robot], 0.9) < 0.4
    write(network, Terms(), Share(0.25, 1.0), path)
    mixed = SecondLook(path, 1).run(inner, traits)
    expected = 0.25 * np.log(alone / (1 - alone)) + 0.75 * ODDS_UNIT * traits[:, 0] + 1.0
    np.testing.assert_allclose(np.log(mixed / (1 - mixed)), expected, atol=1e-3)


@pytest.mark.ultralytics
def test_it_goes_on_from_a_network_that_has_learnt(tmp_path, crosses):
    pytest.importorskip("torch", reason="needs the extra [ultralytics]")
    from aerial_gnss_ros.training.second_look_network import write
    from aerial_gnss_ros.training.second_look_network_fit import fit
    from aerial_gnss_ros.training.second_look_network_pretrained import PretrainedNetwork, read

    path = tmp_path / "look.onnx"
    network = fit(crosses, Terms(), 12, 1, PretrainedNetwork(), threads=1, batch=32)
    write(network, Terms(), Share(), path)
    views, traits = crosses.views[:64, 8:72, 8:72], crosses.traits[:64]
    before = SecondLook(path, 1).run(views, traits)
    write(fit(crosses, Terms(), 1, 2, read(path), threads=1), Terms(), Share(), path)
    after = SecondLook(path, 1).run(views, traits)
    # What it knows of crosses remains, although its first steps of a new training are small.
    robots = crosses.is_robot[:64]
    assert before[robots].mean() > before[~robots].mean()
    np.testing.assert_allclose(after, before, atol=0.2)


def write_set(folder, seed):
    """Bright crosses, labelled, and squares that look alike to a detector of bright boxes."""
    rng = np.random.default_rng(seed)
    for kind in ("images", "labels"):
        (folder / kind / "train").mkdir(parents=True)
    for i in range(6):
        image = np.full((128, 128, 3), 60, np.uint8)
        left, top = rng.integers(20, 70, 2)
        image[top : top + 32, left : left + 32] = 255
        cv2.imwrite(str(folder / f"images/train/{i}.png"), image)
        row = f"0 {(left + 16) / 128} {(top + 16) / 128} 0.25 0.25\n" if i % 2 else ""
        (folder / f"labels/train/{i}.txt").write_text(row)
    return folder


@pytest.mark.ultralytics
def test_the_command_writes_a_file_or_nothing(tmp_path, capsys, monkeypatch):
    pytest.importorskip("torch", reason="needs the extra [ultralytics]")
    import runpy
    from pathlib import Path

    models = Path(__file__).parent.parent / "detection/synthetic_model.py"
    model = runpy.run_path(str(models))["white_box_model"](tmp_path / "m.onnx")
    first, second = write_set(tmp_path / "a", 1), write_set(tmp_path / "b", 2)
    output = tmp_path / "m_second_look.onnx"
    command = [str(model), str(first), "--times", "2", str(second), "--held-out", str(second)]
    command += ["-o", str(output), "--steps", "3", "--threads", "1"]
    assert main(command) == 0
    reported = capsys.readouterr().out
    assert "12 boxes, 6 on robots" in reported
    assert SecondLook(output).terms == Terms()
    further = tmp_path / "further.onnx"
    on = [*command[:-6], "-o", str(further), *command[-4:]]
    stricter = ["--to-score", "1", "--least-recall", "0", "--ways", "4"]
    assert main([*on, "--start", str(output), *stricter]) == 0
    assert "0.000 false boxes an image" in capsys.readouterr().out
    assert SecondLook(further).terms == Terms(to_score=1.0, ways=4)
    chosen = tmp_path / "chosen.onnx"  # for another detector: nothing is learnt
    same = [str(model), "--held-out", str(second), "-o", str(chosen), "--steps", "0"]
    by = [str(model), str(first), "--by", str(model), str(second), *command[5:7], "--steps", "1"]
    assert main([*by, "-o", str(tmp_path / "by.onnx"), "--threads", "1"]) == 0
    assert "12 boxes, 6 on robots" in capsys.readouterr().out
    assert main([*same, "--start", str(further)]) == 0
    assert "the second look counting" in capsys.readouterr().out
    onnx = pytest.importorskip("onnx")
    weights = [
        {item.name: item.raw_data for item in onnx.load(file).graph.initializer}
        for file in (further, chosen)
    ]
    assert weights[0]["network.head.1.weight"] == weights[1]["network.head.1.weight"]
    assert main(command) == 2
    assert "exists already" in capsys.readouterr().err
    output.unlink()
    for wrong, words in (
        (["--times", "two", str(second)], "needs a number"),
        (["--steps", "-1"], "0 or more"),
        (["--by", str(model)], "needs folders on which it finds boxes"),
        (["--by", "other.onnx", str(first)], "the model other.onnx does not exist"),
        (["--to-score", "1.5"], "within 0.03 to 1, got 1.5"),
        (["--ways", "9"], "within 1 to 8, got 9"),
        (["--start", str(tmp_path / "missing.json")], "missing.json is not a whole TensorFlow.js"),
        (["--start", str(model)], "not a second look of this architecture"),
        (["--least-recall", "0.9", "0.8"], "each of the 1 --held-out, got 2"),
    ):
        assert main([*command, *wrong]) == 2
        assert words in capsys.readouterr().err
    monkeypatch.setattr("torch.cuda.is_available", lambda: False)
    assert main([*command, "--device", "cuda"]) == 2
    assert "torch finds no GPU here" in capsys.readouterr().err
    assert not output.exists()
