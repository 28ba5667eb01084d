# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""PyTorch (.pt) and TensorRT (.engine) models through ultralytics; imported only when asked for."""

from __future__ import annotations

import gc
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.core.values.errors import ConfigError, ModelError
from aerial_gnss_ros.detection.base import Detections, Image, within_image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.offline import forbid_network
from aerial_gnss_ros.detection.onnx_model import agreed_names, check_file
from aerial_gnss_ros.resources import install_hint


class UltralyticsDetector:
    """Any detection model that ultralytics can load.

    Only `YOLO`, `predict` and `results[0].boxes` are used: its other names change with versions.

    Args:
        path: the .pt or .engine file.
        config: thresholds, size, device and consent.

    Raises:
        ConfigError: a .pt file without consent.
        ModelError: missing, not installed, not a model, or not a detection model.
    """

    def __init__(self, path: Path, config: DetectorConfig) -> None:
        if path.suffix == ".pt" and not config.allow_pickle:
            raise ConfigError(
                f"{path} is a pickle, which can run any code when it is loaded; set allow_pickle: "
                "true if you trust it, or export it to .onnx."
            )
        check_file(path, kind="a .pt file")
        self._config = config
        self._model = _load(path)
        if self._model.task != "detect":
            raise ModelError(
                f"{path} is for the task {self._model.task}; a model for the task detect is needed."
            )
        self._class_names = self._names(path)
        device = config.device or "its default device"
        self._name = f"{path.name} on ultralytics, {device}"

    @property
    def name(self) -> str:
        """Model, back end and device in words."""
        return self._name

    @property
    def class_names(self) -> tuple[str, ...]:
        """The classes that the model knows."""
        return self._class_names

    def close(self) -> None:
        """Release the device's memory: PyTorch keeps it until asked."""
        self._model = None
        gc.collect()
        torch = sys.modules.get("torch")
        if torch is not None and torch.cuda.is_available():
            torch.cuda.empty_cache()

    def detect(self, image: Image) -> Detections:
        """Return the boxes found in `image` (height, width, 3), blue, green, red."""
        started = time.perf_counter()
        result = self._predict(image)
        done = time.perf_counter()
        boxes = result.boxes
        corners = boxes.xyxy.cpu().numpy()
        scores, classes = boxes.conf.cpu().numpy(), boxes.cls.cpu().numpy()
        timings = {"infer": (done - started) * 1e3, "post": (time.perf_counter() - done) * 1e3}
        size = (image.shape[1], image.shape[0])
        order = np.argsort(-scores, kind="stable")
        return within_image(
            corners[order], scores[order], classes[order], self._class_names, size, timings
        )

    def _predict(self, image: Image) -> Any:
        config = self._config
        asked = {} if not config.device else {"device": config.device}
        longest = min(config.image_size, max(image.shape[:2]))
        return self._model.predict(
            np.ascontiguousarray(image),
            imgsz=longest,
            conf=config.score_threshold,
            iou=config.iou_threshold,
            max_det=config.max_detections,
            verbose=False,
            **asked,
        )[0]

    def _names(self, path: Path) -> tuple[str, ...]:
        try:
            own = self._model.names
        except Exception as error:  # an engine of another device fails here, in many ways
            raise ModelError(f"{path} cannot be loaded on this device: {error}") from error
        names = tuple(str(own[index]) for index in sorted(own))
        return agreed_names(names, self._config.class_names, str(path))


def _load(path: Path) -> Any:
    forbid_network()
    try:
        from ultralytics import YOLO
    except ImportError as error:
        raise ModelError(
            f"{path.name} needs ultralytics; install it with {install_hint('ultralytics')}, or "
            "export the model to .onnx."
        ) from error
    try:
        return YOLO(str(path), task="detect" if path.suffix == ".engine" else None)
    except Exception as error:  # ultralytics and torch raise arbitrary exceptions on damage
        raise ModelError(f"{path} is not a model that ultralytics can read: {error}") from error
