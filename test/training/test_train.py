# SPDX-License-Identifier: Apache-2.0
"""A training of one epoch, exported and loaded; and what is refused."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.errors import InputError, OutputError
from aerial_gnss_ros.training import train
from aerial_gnss_ros.training.export import export


def dataset(folder):
    """Eight grey images with an orange disc in each."""
    rng = np.random.default_rng(0)
    for split in ("train", "val"):
        for kind in ("images", "labels"):
            (folder / kind / split).mkdir(parents=True)
        for i in range(8):
            image = np.full((64, 64, 3), 90, np.uint8)
            u, v = rng.integers(12, 52, 2)
            cv2.circle(image, (int(u), int(v)), 8, (0, 128, 255), -1)
            cv2.imwrite(str(folder / "images" / split / f"{i}.png"), image)
            line = f"0 {u / 64} {v / 64} {17 / 64} {17 / 64}\n"
            (folder / "labels" / split / f"{i}.txt").write_text(line)
    (folder / "data.yaml").write_text(
        f"path: {folder}\ntrain: images/train\nval: images/val\nnames: {{0: aqua}}\n"
    )
    return folder / "data.yaml"


@pytest.mark.ultralytics
@pytest.mark.parametrize("bfloat16", [False, True])
def test_one_epoch_then_export(tmp_path, monkeypatch, bfloat16):
    pytest.importorskip("ultralytics", reason="needs the extra [ultralytics]")
    from aerial_gnss_ros.detection.config import DetectorConfig
    from aerial_gnss_ros.detection.select import load_detector

    monkeypatch.setenv("YOLO_CONFIG_DIR", str(tmp_path))
    arguments = [str(dataset(tmp_path / "set")), "-o", str(tmp_path / "run"), "--minutes", "0"]
    arguments += ["--epochs", "1", "--image-size", "64", "--batch", "4"]
    assert train.main(arguments + ["--bfloat16"] * bfloat16) == 0
    weights, model = tmp_path / "run" / "weights" / "last.pt", tmp_path / "aqua.onnx"
    export(weights, model, (96, 64))
    detector = load_detector(DetectorConfig(model=str(model), backend="onnxruntime"))
    assert detector.class_names == ("aqua",)
    assert "96x64" in detector.name
    assert str(tmp_path) not in model.read_bytes().decode("latin-1")
    assert not list(tmp_path.glob("*.partial"))


@pytest.mark.ultralytics
def test_training_goes_on_from_given_weights(tmp_path, monkeypatch):
    ultralytics = pytest.importorskip("ultralytics", reason="needs the extra [ultralytics]")
    monkeypatch.setenv("YOLO_CONFIG_DIR", str(tmp_path))
    data = str(dataset(tmp_path / "set"))
    common = ["--minutes", "0", "--epochs", "1", "--image-size", "64", "--batch", "4"]
    first, second = tmp_path / "first", tmp_path / "second"
    assert train.main([data, "-o", str(first), "--seed", "1", *common]) == 0
    weights = first / "weights" / "last.pt"
    arguments = [data, "-o", str(second), "--weights", str(weights), *common]
    assert train.main([*arguments, "--learning-rate", "0"]) == 0

    def first_layer(folder):
        model = ultralytics.YOLO(str(folder / "weights" / "last.pt")).model
        return model.state_dict()["model.0.conv.weight"].float().numpy()

    np.testing.assert_array_equal(first_layer(first), first_layer(second))


def test_what_is_refused(tmp_path, capsys):
    assert train.main([str(tmp_path / "none.yaml"), "-o", str(tmp_path / "run")]) == 2
    assert "none.yaml does not exist" in capsys.readouterr().err
    (tmp_path / "data.yaml").touch()
    assert train.main([str(tmp_path / "data.yaml"), "-o", str(tmp_path)]) == 2
    assert "exists already" in capsys.readouterr().err
    with pytest.raises(InputError, match=r"none.pt do not exist"):
        export(tmp_path / "none.pt", tmp_path / "a.onnx")
    (tmp_path / "w.pt").touch()
    with pytest.raises(OutputError, match="exists already"):
        export(tmp_path / "w.pt", tmp_path / "data.yaml")
