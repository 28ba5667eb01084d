# SPDX-License-Identifier: Apache-2.0
"""Chooses the back end by the model's file and the configuration."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from aerial_gnss_ros.core.errors import ConfigError, InputError, ModelError
from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.search import searching

_ULTRALYTICS = (".pt", ".engine")
_ONNX = (".onnx",)


def load_detector(config: DetectorConfig) -> Detector:
    """Return the detector that `config` asks for, ready for its first image.

    Raises:
        ConfigError: a back end that cannot read the model, or a .pt file without consent.
        ModelError: the model is missing, is not a model, has another input or output, or an input
            of one size where `search.mode` needs a free one.
    """
    return searching(_load(config), config)


def _load(config: DetectorConfig) -> Detector:
    path = find_model(config.model)
    backend = choose_backend(path, config.backend)
    if backend == "openvino":
        from aerial_gnss_ros.detection import openvino_backend

        return openvino_backend.load(path, config)
    if backend == "ultralytics":
        from aerial_gnss_ros.detection.ultralytics_backend import UltralyticsDetector

        return UltralyticsDetector(path, config)
    from aerial_gnss_ros.detection import onnx_backend

    return onnx_backend.load(path, config)


def find_model(model: str) -> Path:
    """Return the file that `model` means: a path, or the name of one in the folder models.

    Raises:
        ModelError: no such file.
    """
    if not model:
        raise ModelError("no model is given; set model to the path of an .onnx file.")
    path = Path(model).expanduser()
    if path.exists() or path.name != model:
        return path
    from aerial_gnss_ros.resources import model_path

    try:
        return model_path(model)
    except InputError as error:
        raise ModelError(f"the model {model} does not exist: {error}") from error


def choose_backend(path: Path, asked: str) -> str:
    """Return onnxruntime, openvino or ultralytics.

    Args:
        path: the model's file; only its ending is looked at.
        asked: one of those, or auto.

    Raises:
        ConfigError: the asked one cannot read such a file.
        ModelError: nothing can.
    """
    suffix = path.suffix.lower()
    if suffix not in _ONNX + _ULTRALYTICS:
        raise ModelError(
            f"the model {path} ends in {suffix or 'nothing'!r}; an .onnx, .pt or .engine file is "
            "needed."
        )
    if asked == "auto":
        if suffix in _ULTRALYTICS:
            return "ultralytics"
        return "openvino" if importlib.util.find_spec("openvino") else "onnxruntime"
    if suffix in _ULTRALYTICS and asked != "ultralytics":
        raise ConfigError(
            f"the back end {asked} cannot read {path.name}; choose ultralytics, or export the "
            "model to .onnx."
        )
    return asked
