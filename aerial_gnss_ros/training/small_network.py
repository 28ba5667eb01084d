# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The small detector: a network of 500,000 weights in plain torch, its loss and its export.

It predicts a map of box centres with a box at each place, at an eighth of the image's resolution
(Zhou et al., Objects as Points, 2019). Robots seen from above are small and rarely overlap, so one
map is enough; two coarser levels add the surroundings.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch
from torch import nn
from torch.nn import functional

STRIDE = 8  # px of the image for a place of the map
MULTIPLE = 32  # of which height and width of an image must be multiples
_OPSET, _IR_VERSION = 17, 8  # read by ONNX Runtime 1.17 and later
_WIDTHS = (16, 32, 48, 80, 128)
_PRIOR_ODDS = -4.6  # of a robot at a place: 0.01
_USUAL_PX = 32.0  # a robot's box without evidence
_LARGEST_LOG = 4.0  # of a side over _USUAL_PX


class SmallDetector(nn.Module):  # type: ignore[misc]  # torch is optional
    """Images (n, 3, height, width), red, green, blue, 0 to 1, to maps (n, 4 + classes, h, w).

    The first four: centre less the middle of the place, in places; log of width and height over
    32 px. Then log odds of each class. h and w are an eighth of height and width.
    """

    def __init__(self, classes: int = 1) -> None:
        super().__init__()
        a, b, c, d, e = _WIDTHS
        self.fine = nn.Sequential(
            _layer(3, a, 2), _layer(a, b, 2), _Residual(b), _layer(b, c, 2), _Residual(c),
            _Residual(c),
        )  # fmt: skip
        self.middle = nn.Sequential(_layer(c, d, 2), _Residual(d), _Residual(d))
        self.coarse = nn.Sequential(_layer(d, e, 2), _Residual(e), _Residual(e), _layer(e, d, 1, 1))
        self.joined = nn.Sequential(_Residual(d), _layer(d, c, 1, 1))
        self.head = nn.Sequential(_Residual(c), _layer(c, c, 1), nn.Conv2d(c, 4 + classes, 1))
        with torch.no_grad():
            self.head[-1].weight.mul_(0.1)
            self.head[-1].bias.zero_()
            self.head[-1].bias[4:] = _PRIOR_ODDS

    def forward(self, images: Any) -> Any:
        """Return the maps."""
        fine = self.fine(images)
        middle = self.middle(fine)
        middle = self.joined(middle + _doubled(self.coarse(middle)))
        return self.head(fine + _doubled(middle))


class _Residual(nn.Module):  # type: ignore[misc]
    def __init__(self, channels: int) -> None:
        super().__init__()
        self.inner = nn.Sequential(
            _layer(channels, channels // 2, 1, 1),
            nn.Conv2d(channels // 2, channels, 3, 1, 1, bias=False), nn.BatchNorm2d(channels),
        )  # fmt: skip

    def forward(self, x: Any) -> Any:
        return functional.relu(x + self.inner(x))


def _layer(channels: int, out: int, step: int, side: int = 3) -> Any:
    # ReLU: ONNX Runtime computes it within the convolution, which it does for no smoother one.
    return nn.Sequential(
        nn.Conv2d(channels, out, side, step, side // 2, bias=False), nn.BatchNorm2d(out), nn.ReLU()
    )


def _doubled(x: Any) -> Any:
    return functional.interpolate(x, scale_factor=2.0, mode="nearest")


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
    robots = at.sum().clamp(min=1.0)
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

    def __init__(self, network: SmallDetector) -> None:
        super().__init__()
        self.network = network

    def forward(self, images: Any) -> Any:
        maps = self.network(images)
        return torch.cat([*boxes(maps), maps[:, 4:].sigmoid()], 1).flatten(2)


def write(network: SmallDetector, names: Sequence[str], path: Path) -> None:
    """Write an .onnx file of the contract that `detection` reads, for any size of image.

    Args:
        network: learnt.
        names: of its classes.
        path: of the file, which is overwritten.
    """
    import onnx

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about another exporter, which needs another package
        torch.onnx.export(
            _Exported(network).eval(), torch.zeros((1, 3, 64, 96)), str(path), opset_version=_OPSET,
            input_names=["images"], output_names=["output0"], dynamo=False,
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
