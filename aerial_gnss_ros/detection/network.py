# SPDX-License-Identifier: Apache-2.0
"""A YOLO network in any runtime as a Detector: fit the image in, run, read the output."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.errors import ModelError
from aerial_gnss_ros.detection.base import Detections, Image, within_image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.letterbox import STRIDE
from aerial_gnss_ros.detection.onnx_model import (
    InputSize,
    class_names,
    names_or_numbers,
    tensor,
)
from aerial_gnss_ros.detection.yolo import Head


@dataclass(frozen=True)
class Network:
    """A loaded model, whichever runtime runs it.

    Attributes:
        path: the model's file.
        runtime: runtime and device in words.
        run: from (1, 3, height, width) red, green, blue, 0 to 1, to the list of outputs.
        size: of the input.
        dtype: of the input.
        metadata: what the model says of itself.
    """

    path: Path
    runtime: str
    run: Callable[[NDArray[Any]], list[NDArray[Any]]]
    size: InputSize
    dtype: type[np.generic]
    metadata: Mapping[str, str]


class NetworkDetector:
    """A Detector made of a network.

    Args:
        network: the loaded model.
        config: thresholds and size.

    Raises:
        ModelError: the model cannot be run, or its output is not that of a detection network.
    """

    def __init__(self, network: Network, config: DetectorConfig) -> None:
        self._network = network
        self._config = config
        where = str(network.path)
        names = class_names(network.metadata, config.class_names, where)
        self._head = Head.of(_try(network), len(names) if names else None, where)
        self._class_names = names_or_numbers(names, self._head.classes)

    @property
    def name(self) -> str:
        """Model, runtime and device in words."""
        network = self._network
        return f"{network.path.name} ({network.size.words}) on {network.runtime}"

    @property
    def class_names(self) -> tuple[str, ...]:
        """The classes that the model knows."""
        return self._class_names

    @property
    def fixed_size(self) -> tuple[int, int] | None:
        """Width and height of the input, px; None: any."""
        return self._network.size.fixed

    def detect(self, image: Image) -> Detections:
        """Return the boxes found in `image` (height, width, 3), blue, green, red."""
        config, network = self._config, self._network
        times = [time.perf_counter()]
        box = network.size.letterbox(image, config.image_size)
        values = tensor(box.apply(image), network.dtype)
        times.append(time.perf_counter())
        output = network.run(values)[0]
        times.append(time.perf_counter())
        corners, scores, classes = self._head.decode(
            output, config.score_threshold, config.iou_threshold, config.max_detections
        )
        times.append(time.perf_counter())
        stages = dict(zip(("pre", "infer", "post"), np.diff(times) * 1e3, strict=True))
        size = (image.shape[1], image.shape[0])
        return within_image(
            box.to_source(corners),
            scores,
            classes,
            self._class_names,
            size,
            {stage: float(spent) for stage, spent in stages.items()},
        )


def _try(network: Network) -> tuple[int, ...]:
    """Run once on black: tells the output's true shape, and makes the first image as fast."""
    width, height = network.size.fixed or (2 * STRIDE, 2 * STRIDE)
    try:
        outputs = network.run(np.zeros((1, 3, height, width), network.dtype))
    except Exception as error:  # the runtimes have no common error
        raise ModelError(
            f"{network.path} cannot be run on an image of {width} x {height}: {first_line(error)}"
        ) from error
    if len(outputs) != 1:
        raise ModelError(f"{network.path} has {len(outputs)} outputs; a detection model has one.")
    return tuple(np.shape(outputs[0]))


def first_line(error: Exception) -> str:
    """Return the first line of an error of a runtime, which may have many."""
    lines = str(error).strip().splitlines()
    return lines[0] if lines else type(error).__name__
