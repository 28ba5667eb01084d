# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Writes the file of a network for the second look, with torch."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import torch
from torch import nn

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


class _FromBytes(nn.Module):  # type: ignore[misc]  # torch is optional
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
        network: learnt; takes and returns what `PretrainedNetwork` does.
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
