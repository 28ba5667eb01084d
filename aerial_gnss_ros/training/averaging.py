# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Averages the weights of a network and of others that were fine-tuned from it.

python -m aerial_gnss_ros.training.averaging START TUNED ... --share 0.4 -o AVERAGE

Fine-tuning on few new images forgets some of the old ones. Weights between both are often better on
both (M. Wortsman et al., 2022: Robust fine-tuning of zero-shot models; Model soups), at no cost.
All files are ONNX in 32 bits and of one network, as `aerial-gnss export` writes it.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.bags.partial import partial
from aerial_gnss_ros.core.values.errors import AerialGnssError, ConfigError, ModelError
from aerial_gnss_ros.training.onnx_graph import read_float_model

Weights = dict[str, NDArray[Any]]


def average(start: Path, tuned: Sequence[Path], share: float, output: Path) -> Path:
    """Write the network with weights (1 - share) start + share * mean of tuned.

    Args:
        start: .onnx in fp32; its metadata are kept.
        tuned: networks that were fine-tuned from it.
        share: 0 to 1.
        output: .onnx to write; must not exist.

    Raises:
        ConfigError: `share` is outside 0 to 1, or nothing is tuned.
        ModelError: a file is unusable or of another network, or onnx is not installed.
        OutputError: `output` exists or cannot be written.
    """
    if not 0.0 <= share <= 1.0:
        raise ConfigError(f"--share must lie within 0 to 1, but is {share:g}.")
    if not tuned:
        raise ConfigError("give at least one network that was fine-tuned from the first.")
    made = read_float_model(start)
    import onnx

    own = _weights(made)
    others = [_weights(read_float_model(path)) for path in tuned]
    for path, other in zip(tuned, others, strict=True):
        _check(own, other, start, path)
    for tensor in made.graph.initializer:
        first = own[tensor.name]
        if first.dtype != np.float32:
            continue
        mean = np.mean([other[tensor.name] for other in others], axis=0, dtype=np.float64)
        mixed = ((1.0 - share) * first + share * mean).astype(np.float32)
        tensor.CopyFrom(onnx.numpy_helper.from_array(mixed, tensor.name))
    with partial(output) as file:
        onnx.save(made, file)
    return output


def _weights(model: Any) -> Weights:
    from onnx import numpy_helper

    return {tensor.name: numpy_helper.to_array(tensor) for tensor in model.graph.initializer}


def _check(own: Weights, other: Weights, start: Path, path: Path) -> None:
    """Raise ModelError if the networks differ in more than weights."""
    for name in sorted({*own, *other}):
        one, two = own.get(name), other.get(name)
        if one is None or two is None or one.shape != two.shape or one.dtype != two.dtype:
            raise ModelError(
                f"{path} is another network than {start}: they differ in {name}. Give files that "
                "were fine-tuned from it and exported in the same way."
            )


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line; returns the exit status."""
    parser = argparse.ArgumentParser(prog="averaging", description=__doc__)
    parser.add_argument("start", type=Path, help=".onnx in 32 bits")
    parser.add_argument("tuned", type=Path, nargs="+", help="networks fine-tuned from it")
    parser.add_argument("--share", type=float, default=0.5, help="of the mean of these, 0 to 1")
    parser.add_argument("-o", "--output", type=Path, required=True, help="new .onnx")
    given = parser.parse_args(arguments)
    try:
        average(given.start, given.tuned, given.share, given.output)
    except AerialGnssError as error:
        sys.stderr.write(f"averaging: {error}\n")
        return 2
    sys.stdout.write(f"wrote {given.output}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
