# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Chooses the back end by the model's file and the configuration."""

from __future__ import annotations

import importlib.util
import re
from dataclasses import replace
from pathlib import Path

from aerial_gnss_ros.core.values.errors import ConfigError, InputError, ModelError
from aerial_gnss_ros.core.values.paths import typed_path
from aerial_gnss_ros.detection.anomaly import ANOMALY, AnomalyDetector
from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.engine_card import engine_of
from aerial_gnss_ros.detection.network import NetworkDetector
from aerial_gnss_ros.detection.search import searching
from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.taught import TaughtDetector

AUTO, OFF = "auto", "off"
SECOND_LOOK_SUFFIX = "_second_look.onnx"
_PRECISIONS = re.compile("_(int8|fp16)$")  # the same network, the same mistakes

# The fastest first; the last is tried in any case and reports what is missing.
_AUTO = {
    ".onnx": ("tensorrt", "cuda", "openvino", "onnxruntime"),
    ".engine": ("tensorrt",),
    ".pt": ("ultralytics",),
}
_READ_BY = {**_AUTO, ".engine": ("tensorrt", "ultralytics")}


def load_detector(config: DetectorConfig) -> Detector:
    """Return the detector that `config` selects, ready for its first image.

    Raises:
        ConfigError: a back end that cannot read the model, a .pt file without consent, or a search
            mode that the model anomaly does not have.
        ModelError: the model is missing, is not a model, has another input or output, a fixed
            input size that `search.mode` excludes, or a second look that was trained on boxes of
            another detector.
    """
    second = second_look(config)
    if config.model == ANOMALY:
        return AnomalyDetector(config) if second is None else TaughtDetector(config, second)
    if second is None:
        return searching(_load(config), config)
    if second.terms.class_names:
        raise ModelError(
            f"{second.name} was taught with the model {ANOMALY} and judges its boxes only; set "
            f"model to {ANOMALY}."
        )
    least = min(config.score_threshold, second.terms.from_score)
    return searching(_load(replace(config, score_threshold=least)), config, second)


def second_look(config: DetectorConfig) -> SecondLook | None:
    """Return the network of the second look, or None.

    Raises:
        ModelError: the configured one is missing or invalid.
    """
    if config.second_look == OFF or (config.model, config.second_look) == (ANOMALY, AUTO):
        return None
    if config.second_look != AUTO:
        return SecondLook(find_model(config.second_look, "the second look"), config.threads)
    path = second_look_beside(find_model(config.model))
    return SecondLook(path, config.threads) if path.is_file() else None


def second_look_beside(model: Path) -> Path:
    """Return where the second look of a model is, if it has one."""
    return model.with_name(f"{_PRECISIONS.sub('', model.stem)}{SECOND_LOOK_SUFFIX}")


def _load(config: DetectorConfig) -> Detector:
    path = find_model(config.model)
    *likely, sure = possible_backends(path, config.backend)
    passed_over: list[str] = []
    for backend in likely:
        found = _attempt(backend, path, config)
        if not isinstance(found, ModelError):
            return _remarked(found, passed_over)
        passed_over.append(f"{backend} not used: {found}")
    return _remarked(_loaded(sure, path, config), passed_over)


def _attempt(backend: str, path: Path, config: DetectorConfig) -> Detector | ModelError:
    """Return the detector, or why an installed back end is unusable."""
    try:
        return _loaded(backend, path, config)
    except ModelError as error:
        return error


def _remarked(detector: Detector, passed_over: list[str]) -> Detector:
    if isinstance(detector, NetworkDetector):
        detector.remark = "; ".join(passed_over)
    return detector


def _loaded(backend: str, path: Path, config: DetectorConfig) -> Detector:
    if backend == "tensorrt":
        from aerial_gnss_ros.detection import tensorrt_backend

        return tensorrt_backend.load(path.with_suffix(".engine"), config)
    if backend == "openvino":
        from aerial_gnss_ros.detection import openvino_backend

        return openvino_backend.load(path, config)
    if backend == "ultralytics":
        from aerial_gnss_ros.detection.ultralytics_backend import UltralyticsDetector

        return UltralyticsDetector(path, config)
    from aerial_gnss_ros.detection import onnx_backend

    return onnx_backend.load(path, config, cuda=backend == "cuda")


def find_model(model: str, what: str = "the model") -> Path:
    """Return the file of `model`: a path, or a name in the folder models.

    Args:
        model: path or name.
        what: it is for, for the error.

    Raises:
        ModelError: no such file.
    """
    if not model:
        raise ModelError("no model is given; set model to the path of an .onnx file.")
    path = typed_path(model)
    if path.exists() or path.name != model:
        return path
    from aerial_gnss_ros.resources import model_path

    try:
        return model_path(model)
    except InputError as error:
        shipped = ", ".join(sorted(file.name for file in model_path(".").glob("*.onnx")))
        raise ModelError(
            f"{what} {model} does not exist; give the path of a file, or one of the shipped "
            f"{shipped}."
        ) from error


def possible_backends(path: Path, asked: str) -> list[str]:
    """Return the back ends to try, the fastest first; all but the last may turn out unusable.

    Args:
        path: the model's file; only its ending and the files beside it are examined.
        asked: a back end, or auto.

    Raises:
        ConfigError: the chosen one cannot read such a file.
        ModelError: no back end can.
    """
    suffix = path.suffix.lower()
    if suffix not in _READ_BY:
        has = f"ends in {suffix!r}" if suffix else "has no ending"
        raise ModelError(f"the model {path} {has}; an .onnx, .pt or .engine file is needed.")
    if asked == "auto":
        *faster, last = _AUTO[suffix]
        return [*(name for name in faster if _present(name, path)), last]
    known = _READ_BY[suffix]
    if asked not in known:
        raise ConfigError(
            f"the back end {asked} cannot read {path.name}; choose {' or '.join(known)}, or give "
            "an .onnx file."
        )
    return [asked]


def _present(backend: str, path: Path) -> bool:
    if backend == "tensorrt":
        return importlib.util.find_spec("tensorrt") is not None and engine_of(path) is not None
    if backend == "cuda":
        from aerial_gnss_ros.detection.onnx_backend import has_cuda

        return has_cuda()
    return importlib.util.find_spec(backend) is not None
