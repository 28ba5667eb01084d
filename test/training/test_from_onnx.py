# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""An exported model, taken back into a network to train on, still says the same."""

from __future__ import annotations

import cv2
import numpy as np
import onnx
import onnxruntime
import pytest
from onnx import numpy_helper

from aerial_gnss_ros import cli
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.select import find_model
from aerial_gnss_ros.simulation.dataset import DatasetConfig, generate
from aerial_gnss_ros.training.from_onnx import checkpoint_from_onnx

pytest.importorskip("ultralytics", reason="needs the extra [ultralytics]")
pytestmark = pytest.mark.ultralytics


@pytest.fixture(autouse=True)
def _own_settings(tmp_path, monkeypatch):
    monkeypatch.setenv("YOLO_CONFIG_DIR", str(tmp_path))


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pictures") / "set"
    generate(folder, DatasetConfig({"train": 4}, (160, 160), seed=8))
    images = [cv2.imread(str(path)) for path in sorted(folder.glob("images/train/*"))]
    return np.stack(images)[..., ::-1].transpose(0, 3, 1, 2).astype(np.float32) / 255.0


@pytest.mark.parametrize("calibrated", [False, True])
def test_the_network_gives_what_onnx_runtime_gives(tmp_path, pictures, calibrated):
    import torch
    from ultralytics import YOLO

    model = find_model("aqua_yolo11n.onnx")
    images = [pictures] if calibrated else []
    path = checkpoint_from_onnx(model, tmp_path / "start.pt", images)
    network = YOLO(str(path)).model.eval()
    assert network.names == {0: "aqua"}
    with torch.no_grad():
        ours = network(torch.from_numpy(pictures))[0].numpy()
    session = onnxruntime.InferenceSession(str(model))
    (theirs,) = session.run(None, {"images": pictures})
    np.testing.assert_allclose(ours[:, :4], theirs[:, :4], atol=5e-3)  # px, of up to 160
    np.testing.assert_allclose(ours[:, 4], theirs[:, 4], atol=1e-4)
    if calibrated:  # training begins with normalised channels
        norms = [m for m in network.modules() if isinstance(m, torch.nn.BatchNorm2d)]
        before = [norm.running_mean.clone() for norm in norms]
        network.train()
        with torch.no_grad():
            network(torch.from_numpy(pictures))
        for norm, mean in zip(norms, before, strict=True):
            # The same images again: a step of the running mean changes nothing.
            np.testing.assert_allclose(norm.running_mean, mean, atol=0.02)


@pytest.mark.parametrize("content", [b"", b"not a model"])
def test_what_is_no_model_is_refused(tmp_path, content):
    path = tmp_path / "model.onnx"
    if content:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"model\.onnx"):
        checkpoint_from_onnx(path, tmp_path / "start.pt")
    assert not (tmp_path / "start.pt").exists()


def test_another_architecture_is_refused_with_what_differs(tmp_path):
    with pytest.raises(InputError, match=r"not an export of yolo11s\.yaml: model\.0.* shape"):
        checkpoint_from_onnx(
            find_model("aqua_yolo11n.onnx"), tmp_path / "start.pt", network="yolo11s.yaml"
        )


def test_training_goes_on_from_the_export(tmp_path):
    """One epoch at a rate of next to nothing leaves the weights where they were."""
    import torch
    from ultralytics import YOLO

    generate(tmp_path / "set", DatasetConfig({"train": 8, "val": 4}, (64, 64), seed=8))
    model = find_model("aqua_yolo11n.onnx")
    arguments = ["train", str(tmp_path / "set"), "-o", str(tmp_path / "run"), "--one-phase"]
    arguments += ["--weights", "aqua_yolo11n.onnx", "--epochs", "1", "--threads", "1"]
    arguments += ["--image-size", "64", "--batch", "4", "--learning-rate", "1e-9"]
    assert cli.main(arguments) == 0
    network = YOLO(str(tmp_path / "run" / "best.pt")).model.float().eval()
    first = network.fuse().model[0].conv.weight.detach()
    tensors = {
        item.name: numpy_helper.to_array(item) for item in onnx.load(model).graph.initializer
    }
    assert torch.allclose(
        first, torch.from_numpy(tensors["model.0.conv.weight"].copy()), rtol=0.05, atol=0.05
    )
