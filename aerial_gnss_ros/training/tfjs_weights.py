# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads the weights of a TensorFlow.js graph model: model.json, and the .bin files beside it."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ModelError


def read_tfjs_weights(path: Path) -> dict[str, NDArray[Any]]:
    """Return the arrays of a model by their names.

    The format: `weightsManifest` lists groups; the bytes of a group's arrays follow one another in
    its files, quantised ones as 8 or 16 bits with scale and offset.

    Args:
        path: of the .json file.

    Raises:
        ModelError: a file is missing, cut off or no such model.
    """
    try:
        groups = json.loads(path.read_text())["weightsManifest"]
        return {
            name: array
            for group in groups
            for name, array in _group(
                group["weights"], b"".join((path.parent / f).read_bytes() for f in group["paths"])
            )
        }
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise ModelError(
            f"{path} is not a whole TensorFlow.js model: {error}; give its .json file, with the "
            ".bin files beside it."
        ) from error


def _group(weights: list[dict[str, Any]], content: bytes) -> list[tuple[str, NDArray[Any]]]:
    made, at = list[tuple[str, NDArray[Any]]](), 0
    for item in weights:
        coded = item.get("quantization")
        stored = np.dtype(coded["dtype"] if coded else item["dtype"])
        count = math.prod(item["shape"])
        array = np.frombuffer(content, stored, count, at).astype(item["dtype"])
        if coded and stored.kind == "u":
            array = array * np.float32(coded["scale"]) + np.float32(coded["min"])
        made.append((item["name"], array.reshape(item["shape"])))
        at += count * stored.itemsize
    if at != len(content):
        raise ValueError(f"{len(content)} bytes of weights instead of {at}")
    return made
