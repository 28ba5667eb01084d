# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A network for the second look that learns from scratch, with torch; and the file of any.

350,000 weights: quick to learn and to run, for one recording's water (`aerial-gnss teach`). What
ships has learnt from more (`second_look_network_pretrained.py`).
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import torch
from torch import nn
from torch.nn import functional

from aerial_gnss_ros.detection.second_look_terms import (
    INPUTS,
    METADATA,
    ODDS_UNIT,
    OUTPUT,
    Terms,
)
from aerial_gnss_ros.training.second_look_network_views import scaled
from aerial_gnss_ros.training.share import Share

_OPSET, _IR_VERSION = 17, 8  # read by ONNX Runtime 1.17 and later
_WIDTHS = (24, 32, 64, 96)
_HIDDEN = 64


class Network(nn.Module):  # type: ignore[misc]  # torch is optional
    """Views (n, 6, side, side) and traits (n, 3) to log odds: (n,), or (n, classes).

    Args:
        classes: number of classes that it tells apart; 0: it says only whether a box fits.
    """

    def __init__(self, classes: int = 0) -> None:
        super().__init__()
        self.classes = classes
        first, second, third, fourth = _WIDTHS
        self.body = nn.Sequential(
            _halved(6, first), _halved(first, second), _Residual(second), _halved(second, third),
            _Residual(third), _halved(third, fourth), _Residual(fourth),
        )  # fmt: skip
        self.head = nn.Sequential(
            nn.Linear(2 * fourth + 3, _HIDDEN), nn.SiLU(), nn.Linear(_HIDDEN, max(1, classes))
        )

    def forward(self, views: Any, traits: Any) -> Any:
        """Return log odds that a box fits a robot."""
        seen = self.body(views)
        features = torch.cat([seen.mean((2, 3)), seen.amax((2, 3)), traits], 1)
        odds = self.head(features)
        return odds if self.classes else odds[:, 0]


class _Residual(nn.Module):  # type: ignore[misc]
    def __init__(self, channels: int) -> None:
        super().__init__()
        self.inner = nn.Sequential(
            nn.Conv2d(channels, channels, 3, 1, 1, bias=False), nn.BatchNorm2d(channels), nn.SiLU(),
            nn.Conv2d(channels, channels, 3, 1, 1, bias=False), nn.BatchNorm2d(channels),
        )  # fmt: skip

    def forward(self, x: Any) -> Any:
        return functional.silu(x + self.inner(x))


def _halved(channels: int, out: int) -> Any:
    return nn.Sequential(
        nn.Conv2d(channels, out, 3, 2, 1, bias=False), nn.BatchNorm2d(out), nn.SiLU()
    )


class _FromBytes(nn.Module):  # type: ignore[misc]
    """The network with its pre- and post-processing, as exported."""

    def __init__(self, network: Any, share: Share) -> None:
        super().__init__()
        self.network = network
        self.share = share

    def forward(self, views: Any, traits: Any) -> Any:
        values = scaled(views.permute(0, 3, 1, 2).float() / 255.0)
        odds = self.share.weight * self.network(values, traits)
        first = (1.0 - self.share.weight) * ODDS_UNIT * traits[:, 0]
        first = first[:, None] if self.network.classes else first
        return torch.sigmoid(odds + first + self.share.shift)


def write(network: Any, terms: Terms, share: Share, path: Path) -> None:
    """Write the .onnx file that `detection.second_look` reads.

    Args:
        network: learnt; takes and returns what `Network` does.
        terms: of the look.
        share: of the second look in the score.
        path: of the file, which is overwritten.
    """
    import onnx

    example = (torch.zeros((2, terms.side, terms.side, 6), dtype=torch.uint8), torch.zeros((2, 3)))
    with warnings.catch_warnings():
        # Warning about another exporter, which needs another package.
        warnings.simplefilter("ignore")
        torch.onnx.export(
            _FromBytes(network, share).eval(), example, str(path), input_names=list(INPUTS),
            output_names=[OUTPUT], opset_version=_OPSET, dynamo=False,
            dynamic_axes={name: {0: "boxes"} for name in (*INPUTS, OUTPUT)},
        )  # fmt: skip
    model = onnx.load(path)
    model.ir_version = _IR_VERSION
    item = model.metadata_props.add()
    item.key, item.value = METADATA, terms.text
    onnx.save(model, path)
