# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Exports trained weights to ONNX with ultralytics (AGPL-3.0, the extra [ultralytics])."""

from __future__ import annotations

import logging
import shutil
import tempfile
from pathlib import Path
from typing import Any

from aerial_gnss_ros.bags.partial import partial, refuse_existing
from aerial_gnss_ros.core.values.errors import InputError, ModelError
from aerial_gnss_ros.detection.network import first_line
from aerial_gnss_ros.detection.offline import forbid_network
from aerial_gnss_ros.resources import install_hint

# What ONNX Runtime 1.17 (early 2024, as on Ubuntu 24.04's Python 3.12) reads.
OPSET = 17
IR_VERSION = 8
_METADATA = ("names", "task", "stride", "imgsz", "batch", "license", "version", "author")


def export(weights: Path, model: Path, size: tuple[int, int] | None = None) -> Path:
    """Write `weights` (.pt) as an ONNX model in 32 bits.

    Args:
        weights: of ultralytics; loading them can run arbitrary code.
        model: the .onnx file to write.
        size: width and height of a fixed input, px; None: any multiples of 32.

    Raises:
        InputError: the weights are missing.
        ModelError: ultralytics is not installed, or cannot read the weights.
        OutputError: the model exists.
    """
    if not weights.is_file():
        raise InputError(f"the weights {weights} do not exist.")
    refuse_existing(model)
    forbid_network()
    try:
        import onnx
        from ultralytics import YOLO
    except ImportError as error:
        raise ModelError(
            f"export needs {error.name}; install it with {install_hint('ultralytics')}."
        ) from error
    logging.getLogger("ultralytics").setLevel(logging.ERROR)  # it recommends its own commands
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "weights.pt"  # ultralytics writes beside the weights
        shutil.copyfile(weights, copy)
        sides = 640 if size is None else [size[1], size[0]]
        try:
            written = YOLO(str(copy)).export(
                format="onnx",
                imgsz=sides,
                dynamic=size is None,
                simplify=True,
                opset=OPSET,
                device="cpu",
                verbose=False,
            )
        except Exception as error:  # ultralytics and torch raise whatever the damage causes
            raise ModelError(
                f"{weights} is not a model that ultralytics can export: {first_line(error)}"
            ) from error
        graph = onnx.load(written)
    graph.ir_version = min(graph.ir_version, IR_VERSION)
    _tidy_metadata(graph)
    onnx.checker.check_model(graph)
    with partial(model) as file:
        onnx.save(graph, file)
    return model


def _tidy_metadata(graph: Any) -> None:
    """Keep the metadata that readers need, without paths and dates of this machine."""
    kept = {item.key: item.value for item in graph.metadata_props if item.key in _METADATA}
    del graph.metadata_props[:]
    for key, value in kept.items():
        graph.metadata_props.add(key=key, value=value)
