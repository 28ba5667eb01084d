# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A training of one epoch, exported and loaded; settings of ultralytics for a given time."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.core.values.errors import InputError, OutputError
from aerial_gnss_ros.training import train
from aerial_gnss_ros.training.export import export


@pytest.mark.ultralytics
@pytest.mark.parametrize("bfloat16", [False, True])
def test_one_epoch_then_export(tmp_path, make_set, monkeypatch, capfd, bfloat16):
    pytest.importorskip("ultralytics", reason="needs the extra [ultralytics]")
    from aerial_gnss_ros.detection.config import DetectorConfig
    from aerial_gnss_ros.detection.select import load_detector

    monkeypatch.setenv("YOLO_CONFIG_DIR", str(tmp_path))
    run, model = tmp_path / "run", tmp_path / "aqua.onnx"
    arguments = ["train", str(make_set(tmp_path / "set")), "-o", str(run), "--one-phase"]
    arguments += ["--epochs", "1", "--image-size", "64", "--batch", "4", "--threads", "1"]
    assert cli.main(arguments + ["--bfloat16"] * bfloat16) == 0
    capfd.readouterr()
    export(run / "best.pt", model, (96, 64))
    assert "ultralytics" not in capfd.readouterr().out.lower()  # that is for our results
    detector = load_detector(DetectorConfig(model=str(model), backend="onnxruntime"))
    assert detector.class_names == ("aqua",)
    assert "96x64" in detector.name
    assert str(tmp_path) not in model.read_bytes().decode("latin-1")
    assert not list(tmp_path.glob("*.partial"))


class Callbacks:
    """Keeps what ultralytics would call."""

    def __init__(self):
        self.added = []

    def add_callback(self, name, function):
        self.added.append((name, function))

    def call(self, name, trainer):
        for other, function in self.added:
            if other == name:
                function(trainer)


@pytest.mark.parametrize(
    ("spent", "at", "share"),
    [(0.0, 0.0, 1.0), (0.0, 900.0, 0.505), (600.0, 300.0, 0.505), (0.0, 9e9, 0.01)],
)
def test_the_rate_falls_with_time_from_where_it_was(tmp_path, monkeypatch, spent, at, share):
    now = 5000.0
    monkeypatch.setattr(train.time, "monotonic", lambda: now)
    model, group = Callbacks(), {"lr": 0.0}
    train._fall_with_time(model, train.Training(tmp_path, hours=0.5, learning_rate=0.1), spent)
    trainer = SimpleNamespace(
        epochs=7, start_epoch=6, train_time_start=100.0,
        optimizer=SimpleNamespace(param_groups=[group]),
    )  # fmt: skip
    for moment in ("on_pretrain_routine_start", "on_train_start", "on_train_epoch_start"):
        model.call(moment, trainer)
    assert (trainer.epochs == 7) == (spent == 0.0)
    assert (trainer.train_time_start, trainer.start_epoch) == (100.0 - spent, 0)
    now += at
    model.call("on_train_batch_start", trainer)
    assert group["lr"] == pytest.approx(0.1 * share)


@pytest.mark.parametrize(
    ("epoch", "epochs", "rates"),
    # A cosine from 1 to 0.01, four steps an epoch: 0.505 in the middle, 0.155 at three quarters.
    [(0, 1, [0.1, 0.0855, 0.0505, 0.0155]), (1, 2, [0.0505, 0.0316, 0.0155, 0.0048])],
)
def test_the_rate_falls_within_an_epoch(tmp_path, epoch, epochs, rates):
    model, group = Callbacks(), {"lr": 0.0}
    train._fall_with_steps(model, train.Training(tmp_path, epochs=epochs, learning_rate=0.1))
    trainer = SimpleNamespace(
        epoch=epoch, epochs=epochs, train_loader=range(4),
        optimizer=SimpleNamespace(param_groups=[group]),
    )  # fmt: skip
    for _ in range(2):  # a second pass, as after a kill, begins with the epoch's rate
        model.call("on_train_epoch_start", trainer)
        for rate in rates:
            model.call("on_train_batch_start", trainer)
            assert group["lr"] == pytest.approx(rate, abs=5e-5)


def test_what_cannot_be_exported(tmp_path):
    with pytest.raises(InputError, match=r"none.pt do not exist"):
        export(tmp_path / "none.pt", tmp_path / "a.onnx")
    (tmp_path / "w.pt").touch()
    (tmp_path / "data.yaml").touch()
    with pytest.raises(OutputError, match="exists already"):
        export(tmp_path / "w.pt", tmp_path / "data.yaml")
