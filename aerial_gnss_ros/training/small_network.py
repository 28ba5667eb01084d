# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The small detector: its network in plain torch, its loss, and its files.

It predicts a map of box centres with a box at each place, at an eighth of the image's resolution
(Zhou et al., Objects as Points, 2019). Robots seen from above are small and rarely overlap, so one
map is enough; a coarser one adds the surroundings.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.onnx_model import class_names
from aerial_gnss_ros.training.backbone import (
    CHANNELS,
    Backbone,
    load_coco,
    rectified,
    sees_colours,
)

STRIDE = 8  # px of the image for a place of the map
MULTIPLE = 32  # of which height and width of an image must be multiples
_OPSET, _IR_VERSION = 17, 8  # read by ONNX Runtime 1.17 and later
_WIDTH = 48  # channels of the head
_PRIOR_ODDS = -4.6  # of a robot at a place: 0.01
_USUAL_PX = 32.0  # a robot's box without evidence
_LARGEST_LOG = 4.0  # of a side over _USUAL_PX
_LEAST_ROBOTS = 0.25  # an image by which a loss is divided: batches without robots count no more


class SmallDetector(nn.Module):  # type: ignore[misc]  # torch is optional
    """Images (n, 3, height, width), red, green, blue, 0 to 1, to maps (n, 4 + classes, h, w).

    The first four: centre less the middle of the place, in places; log of width and height over
    32 px. Then log odds of each class. h and w are an eighth of height and width.
    """

    def __init__(self, classes: int = 1) -> None:
        super().__init__()
        self.backbone = Backbone()
        self.fine = nn.Conv2d(CHANNELS[0], _WIDTH, 1)
        self.coarse = nn.Conv2d(CHANNELS[1], _WIDTH, 1)
        self.first = nn.Conv2d(_WIDTH, _WIDTH, 3, 1, 1)
        self.second = nn.Conv2d(_WIDTH, _WIDTH, 3, 1, 1)
        self.last = nn.Conv2d(_WIDTH, 4 + classes, 1)
        with torch.no_grad():
            self.last.weight.mul_(0.1)
            self.last.bias.zero_()
            self.last.bias[4:] = _PRIOR_ODDS

    def forward(self, images: Any) -> Any:
        """Return the maps."""
        fine, coarse = self.backbone(images)
        doubled = functional.interpolate(self.coarse(coarse), scale_factor=2.0, mode="nearest")
        joined = rectified(self.fine(fine) + doubled)
        return self.last(rectified(joined + self.second(rectified(self.first(joined)))))


def from_coco(path: Path, classes: int = 1) -> SmallDetector:
    """Return a network that knows COCO's photographs, and no robot yet.

    Args:
        path: nanodet.json, as for `backbone.load_coco`.
        classes: number of classes.

    Raises:
        ModelError: the file is unreadable, or another network's.
    """
    network = SmallDetector(classes)
    load_coco(network.backbone, path)
    sees_colours(network.backbone)
    return network


def boxes(maps: Any) -> tuple[Any, Any]:
    """Return centres (n, 2, h, w) and sizes (n, 2, h, w) in px; a corner of the image is (0, 0)."""
    height, width = maps.shape[2:]
    x = torch.arange(width, device=maps.device, dtype=maps.dtype)
    y = torch.arange(height, device=maps.device, dtype=maps.dtype)
    place = torch.stack([x[None].expand(height, -1), y[:, None].expand(-1, width)])
    centres = (place[None] + 0.5 + maps[:, :2]) * STRIDE
    return centres, _USUAL_PX * maps[:, 2:4].clamp(-_LARGEST_LOG, _LARGEST_LOG).exp()


def loss(maps: Any, wanted: Any, weight: Any, truth: Any) -> Any:
    """Return the loss of a batch: of the centres' map, and of the boxes near centres.

    Args:
        maps: (n, 4 + classes, h, w) of the network.
        wanted: (n, classes, h, w) 1 at a robot's centre, falling off as a Gaussian.
        weight: (n, 1, h, w) 0 where nothing is known, else 1.
        truth: (n, 4, h, w) centre and size of the robot nearest to each place, px.
    """
    odds = maps[:, 4:]
    chance = odds.sigmoid()
    at = (wanted > 0.999).to(odds)
    found = at * (1.0 - chance).square() * functional.softplus(-odds)
    empty = (1.0 - at) * (1.0 - wanted).pow(4) * chance.square() * functional.softplus(odds)
    robots = at.sum().clamp(min=_LEAST_ROBOTS * len(maps))
    centre_loss = ((found + empty) * weight).sum() / robots
    near = wanted.amax(1, keepdim=True)
    near = near * (near > 0.3) * weight
    total = near.sum().clamp(min=1.0)
    centres, sizes = boxes(maps)
    off = (centres - truth[:, :2]).abs() / STRIDE
    grown = (sizes / truth[:, 2:]).log().abs()
    apart = 1.0 - _generous_iou(centres, sizes, truth[:, :2], truth[:, 2:])
    box_loss = (near * (2.0 * apart + 0.3 * (off + grown).sum(1, keepdim=True))).sum() / total
    return centre_loss + box_loss


def _generous_iou(centres: Any, sizes: Any, true_centres: Any, true_sizes: Any) -> Any:
    """Return the generalized IoU (n, 1, h, w): Rezatofighi et al., CVPR 2019."""
    low, high = centres - sizes / 2, centres + sizes / 2
    true_low, true_high = true_centres - true_sizes / 2, true_centres + true_sizes / 2
    shared = (torch.minimum(high, true_high) - torch.maximum(low, true_low)).clamp(min=0.0)
    inside = shared.prod(1, keepdim=True)
    union = sizes.prod(1, keepdim=True) + true_sizes.prod(1, keepdim=True) - inside
    hull = (torch.maximum(high, true_high) - torch.minimum(low, true_low)).prod(1, keepdim=True)
    return inside / union - (hull - union) / hull


class _Exported(nn.Module):  # type: ignore[misc]
    """The network with YOLO's output: (1, 4 + classes, places) centre, size, scores."""

    def __init__(self, network: SmallDetector, scale: float, shift: float) -> None:
        super().__init__()
        self.network = network
        self.scale, self.shift = scale, shift

    def forward(self, images: Any) -> Any:
        maps = self.network(images)
        scores = (self.scale * maps[:, 4:] + self.shift).sigmoid()
        return torch.cat([*boxes(maps), scores], 1).flatten(2)


def write(
    network: SmallDetector,
    names: Sequence[str],
    path: Path,
    scale: float = 1.0,
    shift: float = 0.0,
) -> None:
    """Write an .onnx file of the contract that `detection` reads, for any size of image.

    Args:
        network: learnt.
        names: of its classes.
        path: of the file, which is overwritten.
        scale: factor of the log odds, and
        shift: what is added to them then (`score_calibration`).
    """
    import onnx

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about another exporter, which needs another package
        torch.onnx.export(
            _Exported(network, scale, shift).eval(), torch.zeros((1, 3, 64, 96)), str(path),
            opset_version=_OPSET, input_names=["images"], output_names=["output0"], dynamo=False,
            dynamic_axes={"images": {2: "height", 3: "width"}, "output0": {2: "boxes"}},
        )  # fmt: skip
    model = onnx.load(path)
    model.ir_version = _IR_VERSION
    for key, value in (
        ("names", str(dict(enumerate(names)))), ("task", "detect"), ("stride", str(MULTIPLE)),
        ("license", "Apache-2.0"),
    ):  # fmt: skip
        item = model.metadata_props.add()
        item.key, item.value = key, value
    onnx.save(model, path)


def read(path: Path, classes: int) -> SmallDetector:
    """Return the network of a file that `write` made, without its scale and shift.

    Args:
        path: of the .onnx file.
        classes: of the network; the last layer is new if the file has another number.

    Raises:
        ModelError: the file is no network of this kind.
    """
    stored = _stored(path)
    network = SmallDetector(classes)
    wanted = network.state_dict()
    known = {name: value for name, value in stored.items() if name in wanted}
    if wanted.keys() - known.keys():
        raise ModelError(
            f"{path} is not a small detector; give one that aerial_gnss_ros.training.small made."
        )
    known = {name: value for name, value in known.items() if value.shape == wanted[name].shape}
    network.load_state_dict(known, strict=False)
    return network


def is_small_detector(path: Path) -> bool:
    """Return whether an .onnx file has all layers of a small detector.

    Raises:
        ModelError: it is not an ONNX model.
    """
    return bool(SmallDetector().state_dict().keys() <= _stored(path).keys())


def names_of(path: Path) -> tuple[str, ...]:
    """Return the classes of a file that `write` made.

    Raises:
        ModelError: it is not an ONNX model, or states no classes.
    """
    stated = {item.key: item.value for item in _model(path).metadata_props}
    names = class_names(stated, (), str(path))
    if names is None:
        raise ModelError(f"{path} states no classes; give one that training.small made.")
    return names


def _stored(path: Path) -> dict[str, Any]:
    from onnx import numpy_helper

    return {
        item.name.removeprefix("network."): torch.from_numpy(np.array(numpy_helper.to_array(item)))
        for item in _model(path).graph.initializer
    }


def _model(path: Path) -> Any:
    import onnx

    try:
        return onnx.load(path)
    except Exception as error:  # protobuf raises its own, which is no part of onnx's interface
        raise ModelError(f"{path} is not an ONNX model: {error}") from error
