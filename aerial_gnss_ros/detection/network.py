# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A YOLO network in any runtime as a Detector: letterbox, inference, decoding."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.base import Detections, Image, within_image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.letterbox import STRIDE, Canvas, Letterbox
from aerial_gnss_ros.detection.onnx_model import (
    InputSize,
    class_names,
    names_or_numbers,
)
from aerial_gnss_ros.detection.yolo import Head

_MEMORY_WORDS = ("bad_alloc", "bad allocation", "out of memory", "failed to allocate")


@dataclass(frozen=True)
class Network:
    """A loaded model, whichever runtime runs it.

    Attributes:
        path: the model's file.
        runtime: runtime and device in words.
        prepare: converts (height, width, 3) blue, green, red, of the input's size, for `run`; only
            a view if the runtime converts colours itself.
        run: returns the list of outputs, which are read before the next run.
        size: of the input.
        metadata: of the model.
        trial: width and height of the black test image, px, if the input size is free; large enough
            for the 300 boxes of an end-to-end head, as 84 of them would look like 80 classes.
        close: releases the device's memory.
        begin: starts a run and returns a function that waits for the outputs; images of other sizes
            may run meanwhile. None: no gain.
    """

    path: Path
    runtime: str
    prepare: Callable[[Image], Any]
    run: Callable[[Any], list[NDArray[Any]]]
    size: InputSize
    metadata: Mapping[str, str]
    trial: tuple[int, int] = (5 * STRIDE, 5 * STRIDE)
    close: Callable[[], None] = lambda: None
    begin: Callable[[Any], Callable[[], list[NDArray[Any]]]] | None = None


@dataclass(frozen=True)
class _Running:
    """An image being processed.

    Attributes:
        image: as given.
        box: its letterbox.
        pre_ms: duration of letterboxing.
        outputs: function that waits for the outputs.
    """

    image: Image
    box: Letterbox
    pre_ms: float
    outputs: Callable[[], list[NDArray[Any]]]


class NetworkDetector:
    """A Detector based on a network.

    Args:
        network: the loaded model.
        config: thresholds and size.

    Attributes:
        remark: appended to the name, such as faster back ends that were unusable and why.

    Raises:
        ModelError: the model cannot be run, or is not a detection network.
    """

    def __init__(self, network: Network, config: DetectorConfig) -> None:
        self._network = network
        self._config = config
        where = str(network.path)
        names = class_names(network.metadata, config.class_names, where)
        self._head = Head.of(_try(network), len(names) if names else None, where)
        self._class_names = names_or_numbers(names, self._head.classes)
        self._canvas = Canvas()
        self.remark = ""

    @property
    def name(self) -> str:
        """Model, runtime and device in words."""
        network = self._network
        words = f"{network.path.name} ({network.size.words}) on {network.runtime}"
        return f"{words} ({self.remark})" if self.remark else words

    def close(self) -> None:
        """Release the device's memory if the runtime needs an explicit call."""
        self._network.close()

    @property
    def class_names(self) -> tuple[str, ...]:
        """The classes that the model knows."""
        return self._class_names

    @property
    def fixed_size(self) -> tuple[int, int] | None:
        """Width and height of the input, px; None: any."""
        return self._network.size.fixed

    def detect(self, image: Image) -> Detections:
        """Return the boxes found in `image` (height, width, 3), blue, green, red.

        Raises:
            ModelError: the runtime failed, for example out of memory; the next image may succeed.
        """
        return self._detect(image, self._fitted(image))

    def detect_all(self, images: Sequence[Image]) -> list[Detections]:
        """Return the boxes of each image; the largest input runs in parallel to the others.

        Their milliseconds add up to the elapsed time.

        Raises:
            ModelError: as `detect`.
        """
        begin, boxes = self._network.begin, [self._fitted(image) for image in images]
        sizes = [box.network for box in boxes]  # images of several sizes may be reduced to one
        if begin is None or len(set(sizes)) < 2:
            return [self._detect(*each) for each in zip(images, boxes, strict=True)]
        largest = max(range(len(images)), key=lambda i: math.prod(sizes[i]))
        running = self._running(images[largest], boxes[largest], begin)
        found: dict[int, Detections] = {}
        try:
            for i, image in enumerate(images):
                if sizes[i] != sizes[largest]:
                    found[i] = self._detect(image, boxes[i])
        finally:
            found[largest] = self._found(running)
        return [
            found[i] if i in found else self._detect(images[i], boxes[i])
            for i in range(len(images))
        ]

    def _fitted(self, image: Image) -> Letterbox:
        return self._network.size.letterbox(image, self._config.image_size)

    def _detect(self, image: Image, box: Letterbox) -> Detections:
        run = self._network.run
        return self._found(self._running(image, box, lambda values: lambda: run(values)))

    def _running(
        self, image: Image, box: Letterbox, begin: Callable[[Any], Callable[[], list[NDArray[Any]]]]
    ) -> _Running:
        network, started = self._network, time.perf_counter()
        with self._told(image):
            values = network.prepare(self._canvas.fill(box, image))
            pre_ms = 1e3 * (time.perf_counter() - started)
            return _Running(image, box, pre_ms, begin(values))

    def _found(self, running: _Running) -> Detections:
        config, times = self._config, [time.perf_counter()]
        with self._told(running.image):
            output = running.outputs()[0]
        times.append(time.perf_counter())
        corners, scores, classes = self._head.decode(
            output, config.score_threshold, config.iou_threshold, config.max_detections
        )
        times.append(time.perf_counter())
        infer_ms, post_ms = (float(spent) for spent in np.diff(times) * 1e3)
        return within_image(
            running.box.to_source(corners),
            scores,
            classes,
            self._class_names,
            (running.image.shape[1], running.image.shape[0]),
            {"pre": running.pre_ms, "infer": infer_ms, "post": post_ms},
        )

    @contextmanager
    def _told(self, image: Image) -> Iterator[None]:
        try:
            yield
        except Exception as error:  # the runtimes have no common error
            raise ModelError(self._failure(image, error)) from error

    def _failure(self, image: Image, error: Exception) -> str:
        name, size = self._network.path.name, f"{image.shape[1]} x {image.shape[0]}"
        text = first_line(error)
        if isinstance(error, MemoryError) or any(word in text.lower() for word in _MEMORY_WORDS):
            return (
                f"{name} ran out of memory on an image of {size}; lower image_size or stop other "
                "programs."
            )
        return f"{name} failed on an image of {size}: {text}"


def _try(network: Network) -> tuple[int, ...]:
    """Run once on a black image: determines the output's shape and warms up the network."""
    width, height = network.size.fixed or network.trial
    try:
        outputs = network.run(network.prepare(np.zeros((height, width, 3), np.uint8)))
    except Exception as error:  # the runtimes have no common error
        raise ModelError(
            f"{network.path} cannot be run on an image of {width} x {height}: {first_line(error)}"
        ) from error
    if len(outputs) != 1:
        raise ModelError(f"{network.path} has {len(outputs)} outputs; a detection model has one.")
    return tuple(np.shape(outputs[0]))


def first_line(error: Exception) -> str:
    """Return the first line of a runtime's error."""
    lines = str(error).strip().splitlines()
    return lines[0] if lines else type(error).__name__
