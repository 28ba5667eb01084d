# SPDX-License-Identifier: Apache-2.0
"""Exports trained weights to ONNX with ultralytics (AGPL-3.0, the extra [ultralytics]).

python -m aerial_gnss_ros.training.export WEIGHTS.pt -o MODEL.onnx
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

from aerial_gnss_ros.core.errors import AerialGnssError, InputError, ModelError, OutputError

# What ONNX Runtime 1.17 (early 2024, as on Ubuntu 24.04's Python 3.12) reads.
OPSET = 17
IR_VERSION = 8
_METADATA = ("names", "task", "stride", "imgsz", "batch", "license", "version", "author")


def export(weights: Path, model: Path, size: tuple[int, int] | None = None) -> Path:
    """Write `weights` (.pt) as an ONNX model in 32 bits.

    Args:
        weights: of ultralytics; loading it runs whatever its author put there.
        model: the .onnx file to write.
        size: width and height of a fixed input, px; None: any multiples of 32.

    Raises:
        InputError: the weights are missing.
        ModelError: ultralytics is not installed.
        OutputError: the model exists.
    """
    if not weights.is_file():
        raise InputError(f"the weights {weights} do not exist.")
    if model.exists():
        raise OutputError(f"the model {model} exists already; give another name or remove it.")
    os.environ.setdefault("YOLO_OFFLINE", "true")
    os.environ.setdefault("YOLO_AUTOINSTALL", "false")
    try:
        import onnx
        from ultralytics import YOLO
    except ImportError as error:
        raise ModelError(
            f"export needs {error.name}; install it with `pip install "
            "'aerial_gnss_ros[ultralytics]'`."
        ) from error
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "weights.pt"  # ultralytics writes beside the weights
        shutil.copyfile(weights, copy)
        sides = 640 if size is None else [size[1], size[0]]
        written = YOLO(str(copy)).export(
            format="onnx",
            imgsz=sides,
            dynamic=size is None,
            simplify=True,
            opset=OPSET,
            device="cpu",
            verbose=False,
        )
        graph = onnx.load(written)
    graph.ir_version = min(graph.ir_version, IR_VERSION)
    _tidy_metadata(graph)
    onnx.checker.check_model(graph)
    partial = model.with_name(f".{model.name}.partial")
    onnx.save(graph, partial)
    partial.replace(model)
    return model


def _tidy_metadata(graph: Any) -> None:
    """Keep what readers need; paths and dates of this machine are nobody's business."""
    kept = {item.key: item.value for item in graph.metadata_props if item.key in _METADATA}
    del graph.metadata_props[:]
    for key, value in kept.items():
        graph.metadata_props.add(key=key, value=value)


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line; returns the exit status."""
    parser = argparse.ArgumentParser(prog="export", description=__doc__)
    parser.add_argument("weights", type=Path, help="trained weights, .pt")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the .onnx file")
    parser.add_argument(
        "--size", type=int, nargs=2, metavar=("WIDTH", "HEIGHT"), help="fixed input; else any"
    )
    given = parser.parse_args(arguments)
    size = (given.size[0], given.size[1]) if given.size else None
    try:
        model = export(given.weights, given.output, size)
    except AerialGnssError as error:
        sys.stderr.write(f"export: {error}\n")
        return 2
    sys.stdout.write(f"{model}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
