# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss train` from the command line: what it refuses before torch is even loaded."""

from __future__ import annotations

import importlib.util
import json
import sys

import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.training import supervise
from aerial_gnss_ros.training.phases import Phase
from aerial_gnss_ros.training.run_folder import Plan, RunFolder


def refused(capsys, *arguments):
    assert cli.main(["train", *map(str, arguments)]) == 2
    said = capsys.readouterr().err
    assert "Traceback" not in said
    return said


def test_check_counts_without_training(tmp_path, make_set, capsys):
    assert cli.main(["train", str(make_set(tmp_path / "set", robots=(1, 2, 0))), "--check"]) == 0
    out = capsys.readouterr().out
    assert "train: 3 images, 3 robots; images with one: 1, several: 1, none: 1" in out
    assert "fingerprint " in out
    few = str(make_set(tmp_path / "few", robots=(1, 0)))
    assert cli.main(["train", few, "--check", "--one-phase"]) == 0
    assert "show 1 robot, too few to train on; label more" in capsys.readouterr().err
    single = str(make_set(tmp_path / "single", robots=(1, 0)))
    assert cli.main(["train", single, "--check", "--one-phase", "--json"]) == 0
    counts = {"images": 2, "robots": 1, "one": 1, "several": 0, "none": 1}
    assert json.loads(capsys.readouterr().out)["splits"] == {"train": counts, "val": counts}
    assert "none of the 2 training images shows several robots" in refused(
        capsys, single, "--check"
    )  # as training would refuse it


def test_a_set_with_errors_is_refused(tmp_path, make_set, capsys, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: True)  # as if torch was there
    source, run = make_set(tmp_path / "set"), tmp_path / "run"
    (source / "labels" / "val" / "1.txt").write_text("0 0.5 0.5 0.1 7\n")
    (source / "images" / "val" / "2.png").unlink()
    for said in (refused(capsys, source, "--check"), refused(capsys, source, "-o", run)):
        assert "with 2 errors; no work was done" in said
        assert "labels/val/1.txt, line 1: the size" in said
        assert "labels/val/2.txt: its image is missing" in said
    assert not run.exists()


def test_a_missing_extra_is_named(tmp_path, make_set, capsys, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    said = refused(capsys, make_set(tmp_path / "set"), "-o", tmp_path / "run")
    assert 'training needs torch; install it with `pip install ".[ultralytics]"` in /' in said
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--epochs", "3"], "the curriculum has two phases"),
        (["--epochs", "3,x"], "is not one or two whole numbers"),
        (["--epochs", "0,1"], "epochs must lie within"),
        (["--image-size", "100"], "must be a multiple of 32"),
        (["--batch", "0"], "--batch must lie within"),
        (["--learning-rate", "nan"], "--learning-rate must lie within"),
        (["--device", "gpu"], "--device is cpu or the number"),
        (["--threads", "-1"], "--threads must lie within"),
        (["--weights", "yolo11n.pt"], "do not exist; nothing is downloaded"),
        (["--weights", "model.bin"], "is no .onnx, .pt or .yaml file"),
        (["--weights", "none.onnx"], "none.onnx"),
        (["--weights", "here.pt"], "is a pickle, which can run any code"),
        (["--time", "0"], "--time must be above 0"),
        (["--time", "nan"], "--time must be above 0"),
        (["--time", "1", "--epochs", "3,3"], "--epochs and --time both set the duration"),
        (["--freeze", "3"], "--freeze 3 would keep random layers"),
        (["--freeze", "-1"], "--freeze must lie within"),
        (["--bfloat16", "--device", "0"], "--bfloat16 is for a processor, not for --device 0"),
    ],
)
def test_wrong_arguments(tmp_path, make_set, capsys, monkeypatch, arguments, expected):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "here.pt").touch()
    said = refused(capsys, make_set(tmp_path / "set"), "-o", "run", *arguments)
    assert expected in said
    assert not (tmp_path / "run").exists()


def test_a_phase_without_images_is_refused(tmp_path, make_set, capsys, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: True)
    said = refused(capsys, make_set(tmp_path / "set", robots=(1, 1)), "-o", tmp_path / "run")
    assert "none of the 2 training images shows several robots" in said


def test_who_stops_it_reads_how_to_go_on(tmp_path, make_set, capfd, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: True)
    stop = "import os, sys; os.kill(os.getppid(), 15); sys.stdin.read(); print('{}')"
    monkeypatch.setattr(supervise, "COMMAND", (sys.executable, "-c", stop))
    run = tmp_path / "run"
    assert cli.main(["train", str(make_set(tmp_path / "set")), "-o", str(run)]) == 130
    assert f"stopped; continue with aerial-gnss train --resume {run}" in capfd.readouterr().err
    assert RunFolder(run).load().phases == (Phase("single", 100), Phase("several", 100))


def test_an_error_before_anything_was_learnt_leaves_nothing(
    tmp_path, make_set, capsys, monkeypatch
):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: True)
    fail = 'print(\'{"error": "no good."}\'); exit(2)'
    monkeypatch.setattr(supervise, "COMMAND", (sys.executable, "-c", fail))
    run = RunFolder(tmp_path / "run")
    assert "no good." in refused(capsys, make_set(tmp_path / "set"), "-o", run.path)
    assert not run.path.exists()
    run.path.mkdir()
    run.save(Plan(tmp_path / "data.yaml", "", False, (Phase("all", 1),), "yolo11n.yaml"))
    assert "no good." in refused(capsys, "--resume", run.path)
    assert run.plan_file.exists()  # that one is somebody's


def test_another_data_set_does_not_take_the_place_of_the_first(
    tmp_path, make_set, capsys, monkeypatch
):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: True)
    run = RunFolder(tmp_path / "run")
    run.path.mkdir()
    plan = Plan(make_set(tmp_path / "a") / "data.yaml", "x", False, (Phase("all", 1),), "n.yaml")
    run.save(plan)
    other = make_set(tmp_path / "b", robots=(2, 2))
    said = refused(capsys, other, "--resume", run.path)
    assert f"{other / 'data.yaml'} is not the data set of this training" in said
    assert run.load() == plan


def test_what_can_be_resumed(tmp_path, capsys):
    assert "give a DATASET and -o RUN" in refused(capsys)
    assert "has no plan.json" in refused(capsys, "--resume", tmp_path)
    run = RunFolder(tmp_path)
    run.save(Plan(tmp_path / "data.yaml", "", False, (Phase("all", 1),), "yolo11n.yaml"))
    said = refused(capsys, "--resume", tmp_path, "--epochs", "3,3", "--seed", "1", "--one-phase")
    assert "a resumed training keeps its options: leave out --epochs, --one-phase, --seed." in said
    said = refused(capsys, "--resume", tmp_path, "--time", "2", "--unlabelled", "empty")
    assert "leave out --time, --unlabelled." in said
    assert "--batch must lie within" in refused(capsys, "--resume", tmp_path, "--batch", "0")
    run.weights.touch()
    assert "is already finished" in refused(capsys, "--resume", tmp_path)
    assert "exists already" in refused(capsys, tmp_path, "-o", tmp_path)
