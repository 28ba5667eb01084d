# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Puts the weights of an exported ONNX model back into an ultralytics network, to train on.

Unlike a .pt, an ONNX file runs no code when it is loaded, so weights are stored and distributed in
it; this module makes them trainable again.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import InputError, ModelError
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.detection.letterbox import Letterbox
from aerial_gnss_ros.detection.offline import forbid_network
from aerial_gnss_ros.detection.onnx_model import class_names
from aerial_gnss_ros.resources import install_hint
from aerial_gnss_ros.training.labelled import ENDINGS

_BATCH = 16
_LEAST_SPREAD = 1e-2  # of a convolution's outputs: inactive channels are left unchanged


def checkpoint_from_onnx(
    model: Path,
    checkpoint: Path,
    images: Iterable[NDArray[np.float32]] = (),
    network: str = "yolo11n.yaml",
) -> Path:
    """Write a .pt for further training, with exactly the output of an ONNX model.

    The export merged each normalisation into the convolution before it. Here they are separated
    again: convolutions get unit variance over `images`, normalisations the scale and shift that
    restore the output. Training then works as it did before the export. Without images the
    normalisations do nothing (mean 0, variance 1), which suits only a very short training.

    Args:
        model: exported by ultralytics, names of its tensors kept.
        checkpoint: the .pt to write.
        images: batches (n, 3, height, width), red green blue, 0 to 1, sides multiples of 32.
        network: ultralytics' description of the architecture.

    Returns:
        `checkpoint`.

    Raises:
        InputError: the model is missing, or not of this architecture.
        ModelError: ultralytics or onnx is not installed.
    """
    if not model.is_file():
        raise InputError(f"the weights {model} do not exist.")
    tensors, names = _read(model)
    torch_model = _network(network, names)
    _fill(torch_model, tensors, f"{model} is not an export of {network}")
    _restore_normalisation(torch_model, images)
    import torch

    checkpoint.parent.mkdir(parents=True, exist_ok=True)
    state = {"model": torch_model, "ema": None, "optimizer": None, "epoch": -1, "train_args": {}}
    torch.save(state, checkpoint)
    return checkpoint


def training_batches(data: Path, side: int, count: int = 128) -> Iterator[NDArray[np.float32]]:
    """Yield up to `count` training images of a YOLO data.yaml, evenly sampled, for the above.

    Args:
        data: the data.yaml.
        side: of the square that images are fitted into, px; a multiple of 32.
        count: how many images.
    """
    from ultralytics.data.utils import check_det_dataset

    folders = check_det_dataset(str(data), autodownload=False)["train"]
    names = [folders] if isinstance(folders, str) else folders
    paths = [path for name in names for path in sorted(Path(name).rglob("*"))]
    paths = [path for path in paths if path.suffix.lower() in ENDINGS]
    for first in range(0, min(count, len(paths)), _BATCH):
        chosen = paths[first * len(paths) // count :: max(1, len(paths) // count)][:_BATCH]
        fitted = []
        for path in chosen:
            image = read_image(path)
            fit = Letterbox.fixed((image.shape[1], image.shape[0]), (side, side))
            fitted.append(fit.apply(image)[..., ::-1].transpose(2, 0, 1))
        yield np.stack(fitted).astype(np.float32) / np.float32(255.0)


def _read(model: Path) -> tuple[dict[str, NDArray[np.float32]], dict[int, str]]:
    try:
        import onnx
        from onnx import numpy_helper
    except ImportError as error:
        raise _lacking(error) from error
    try:
        graph = onnx.load(model)
    except Exception as error:  # protobuf raises its own, which is no part of onnx's interface
        raise InputError(
            f"{model} is not an ONNX model: {' '.join(str(error).split())[:200]}"
        ) from error
    tensors = {item.name: numpy_helper.to_array(item) for item in graph.graph.initializer}
    metadata = {item.key: item.value for item in graph.metadata_props}
    names = class_names(metadata, (), str(model)) or ("object",)
    return tensors, dict(enumerate(names))


def _network(description: str, names: dict[int, str]) -> Any:
    forbid_network()
    try:
        from ultralytics.nn.tasks import DetectionModel
    except ImportError as error:
        raise _lacking(error) from error
    network = DetectionModel(description, nc=len(names), verbose=False)
    network.names = names
    return network.eval()


def _lacking(error: ImportError) -> ModelError:
    return ModelError(
        f"training from ONNX needs {error.name}; install it with {install_hint('ultralytics')}."
    )


def _fill(network: Any, tensors: dict[str, NDArray[np.float32]], otherwise: str) -> None:
    """Set every convolution to its exported weights, every normalisation to the identity."""
    import torch

    for name, layer in network.named_modules():
        if isinstance(layer, torch.nn.BatchNorm2d):
            torch.nn.init.zeros_(layer.running_mean)
            torch.nn.init.constant_(layer.running_var, 1.0 - layer.eps)
            torch.nn.init.ones_(layer.weight)
            bias = tensors.get(f"{name.removesuffix('bn')}conv.bias")
            _copy(layer.bias, bias, otherwise, name)
        elif isinstance(layer, torch.nn.Conv2d) and layer.weight.requires_grad:
            _copy(layer.weight, tensors.get(f"{name}.weight"), otherwise, name)
            if layer.bias is not None:
                _copy(layer.bias, tensors.get(f"{name}.bias"), otherwise, name)


def _copy(into: Any, values: NDArray[np.float32] | None, otherwise: str, name: str) -> None:
    import torch

    if values is None:
        raise InputError(f"{otherwise}: it lacks the weights of {name}.")
    if tuple(values.shape) != tuple(into.shape):
        raise InputError(
            f"{otherwise}: {name} has the shape {list(values.shape)}, not {list(into.shape)}."
        )
    with torch.no_grad():
        into.copy_(torch.from_numpy(np.array(values, dtype=np.float32)))


def _restore_normalisation(network: Any, images: Iterable[NDArray[np.float32]]) -> None:
    """Scale convolutions before normalisations to unit variance with unchanged output."""
    import torch

    layers = dict(network.named_modules())
    blocks = [
        name
        for name, layer in layers.items()
        if isinstance(getattr(layer, "bn", None), torch.nn.BatchNorm2d)
    ]
    sums: dict[str, list[Any]] = {name: [0.0, 0.0, 0] for name in blocks}

    def watch(total: list[Any]) -> Any:
        def add(_: Any, __: Any, output: Any) -> None:
            wide = output.double()
            total[0] += wide.mean((0, 2, 3))
            total[1] += wide.square().mean((0, 2, 3))
            total[2] += 1

        return add

    hooks = [layers[name].conv.register_forward_hook(watch(sums[name])) for name in blocks]
    with torch.no_grad():
        for batch in images:
            network(torch.from_numpy(np.ascontiguousarray(batch)))
        for hook in hooks:
            hook.remove()
        for name, (mean, square, count) in sums.items():
            if not count:
                continue
            centre = mean / count
            spread = (
                (square / count - centre.square()).clamp(min=0.0).sqrt().clamp(min=_LEAST_SPREAD)
            )
            conv, norm = layers[name].conv, layers[name].bn
            conv.weight.div_(spread[:, None, None, None].float())
            norm.running_mean.copy_(centre / spread)
            norm.running_var.fill_(1.0)
            norm.weight.copy_(spread * (1.0 + norm.eps) ** 0.5)
            norm.bias.add_(centre.float())
