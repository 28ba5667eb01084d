# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The network that ships: COCO's weights into it, out to its file, back, and as it is run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.second_look_terms import Terms
from aerial_gnss_ros.training.share import Share

pytestmark = pytest.mark.ultralytics
torch = pytest.importorskip("torch", reason="needs the extra [ultralytics]")
SHIPPED = Path(__file__).parents[2] / "models/aqua_yolo11n_second_look.onnx"


@pytest.fixture
def networks():
    from aerial_gnss_ros.training import second_look_network_pretrained

    return second_look_network_pretrained


@pytest.fixture
def network(networks):
    torch.manual_seed(4)
    return networks.PretrainedNetwork().eval()


def inputs(count):
    rng = np.random.default_rng(5)
    return (
        rng.integers(0, 255, (count, 64, 64, 6), np.uint8),
        rng.normal(0.0, 1.0, (count, 3)).astype(np.float32),
    )


def odds_of(network, views, traits):
    from aerial_gnss_ros.training.second_look_network_views import scaled

    values = torch.from_numpy(views).permute(0, 3, 1, 2).float() / 255.0
    with torch.no_grad():
        return network(scaled(values), torch.from_numpy(traits)).numpy()


def test_its_file_gives_the_same_scores_for_any_number_of_boxes(tmp_path, networks, network):
    from aerial_gnss_ros.training.second_look_network import write

    path = tmp_path / "look.onnx"
    write(network, Terms(), Share(), path)
    second = SecondLook(path, 1)
    for count in (1, 5):
        views, traits = inputs(count)
        wanted = 1.0 / (1.0 + np.exp(-odds_of(network, views, traits)))
        np.testing.assert_allclose(second.run(views, traits), wanted, atol=1e-5)
    again = networks.read(path)
    np.testing.assert_array_equal(odds_of(again, *inputs(3)), odds_of(network, *inputs(3)))


def test_the_near_and_the_wide_view_count_differently(network):
    views, traits = inputs(2)
    exchanged = np.concatenate([views[..., 3:], views[..., :3]], axis=-1)
    assert np.abs(odds_of(network, views, traits) - odds_of(network, exchanged, traits)).min() > 0.0


def test_the_shipped_one_can_be_gone_on_from(networks):
    views, traits = inputs(2)
    second = SecondLook(SHIPPED, 1)
    alone = odds_of(networks.read(SHIPPED), views, traits)
    mixed = second.run(views, traits)
    mixed = np.log(mixed / (1.0 - mixed))
    # The file adds the detector's log odds, 3 times the first trait, and shifts both.
    weights, *_ = np.linalg.lstsq(
        np.stack([alone - alone[::-1], 3.0 * (traits[:, 0] - traits[::-1, 0])], axis=1),
        mixed - mixed[::-1], rcond=None,
    )  # fmt: skip
    assert 0.0 <= weights[0] <= 1.0


def stored(network, folder):
    """Write a network's backbone as NanoDet-g is: 16 bits, height, width, in, out."""
    layers = [one for one in network.backbone.modules() if isinstance(one, torch.nn.Conv2d)]
    weights, content = [], b""
    for i, layer in enumerate(layers):
        name = "PartitionedCall/split" + (f"_{i}" if i else "")
        kernel = layer.weight.detach().permute(2, 3, 1, 0).numpy()
        for key, array in ((name, kernel), (f"unknown_{2 * i}", layer.bias.detach().numpy())):
            weights.append({
                "name": key, "shape": list(array.shape), "dtype": "float32",
                "quantization": {"dtype": "float16"},
            })  # fmt: skip
            content += array.astype(np.float16).tobytes()
    (folder / "net.bin").write_bytes(content)
    path = folder / "net.json"
    group = {"paths": ["net.bin"], "weights": weights}
    path.write_text(json.dumps({"weightsManifest": [group]}))
    return path


def test_it_starts_from_the_weights_of_coco(tmp_path, networks, network):
    found = networks.from_coco(stored(network, tmp_path)).backbone.state_dict()
    for name, value in network.backbone.state_dict().items():
        torch.testing.assert_close(found[name], value, rtol=1e-3, atol=1e-3)


def test_it_begins_with_what_a_small_detector_has_learnt(networks):
    from aerial_gnss_ros.training.backbone import DEVIATION, MEAN
    from aerial_gnss_ros.training.small_network import read

    detector = SHIPPED.with_name("aqua_small.onnx")
    network = networks.start_from(detector)
    image = torch.rand((1, 3, 64, 64))
    levels = 255.0 * image.flip(1)  # blue, green, red
    scaled = (levels - torch.tensor(MEAN).reshape(1, 3, 1, 1)) / torch.tensor(DEVIATION).reshape(
        1, 3, 1, 1
    )
    inner = (slice(None), slice(None), slice(1, None), slice(1, None))  # the border is another
    torch.testing.assert_close(
        network.backbone.stem(scaled)[inner], read(detector, 1).backbone.stem(image)[inner],
        atol=1e-4, rtol=1e-4,
    )  # fmt: skip


def test_another_network_is_refused(tmp_path, networks, network):
    path = stored(network, tmp_path)
    other = json.loads(path.read_text())
    other["weightsManifest"][0]["weights"][0]["name"] = "conv1"
    path.write_text(json.dumps(other))
    with pytest.raises(ModelError, match=r"is not NanoDet-g.*nanodet\.json"):
        networks.from_coco(path)
    wrong = tmp_path / "wrong.onnx"
    wrong.write_bytes(b"no model")
    with pytest.raises(ModelError, match="not an ONNX model"):
        networks.read(wrong)
    with pytest.raises(ModelError, match="not a second look of this architecture"):
        networks.read(SHIPPED.with_name("aqua_yolo11n.onnx"))
