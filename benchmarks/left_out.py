# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What could make detection faster, measured, and why it is done or not: docs/results/detection.md.

    python benchmarks/left_out.py

Needs OpenVINO. Processor time of all threads, ms, medians, taken in turns; it does not see how long
threads wait for a free core, so that other programs disturb it little.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

from aerial_gnss_ros.detection.onnx_model import tensor
from aerial_gnss_ros.resources import model_path

RNG = np.random.default_rng(0)
PICTURE = cv2.GaussianBlur(RNG.integers(0, 255, (720, 1280, 3), dtype=np.uint8), (0, 0), 2.0)
INPUT = np.ascontiguousarray(np.pad(PICTURE, ((8, 8), (0, 0), (0, 0))))


def medians(works: dict[str, Callable[[], Any]], rounds: int = 9) -> dict[str, float]:
    """Return the median processor time of each work, ms."""
    spent: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(rounds + 1):
        for name, work in works.items():
            started = time.process_time()
            work()
            spent[name].append((time.process_time() - started) * 1e3)
    return {name: float(np.median(values[1:])) for name, values in spent.items()}


def network(threads: int, streams: int, shape: list[int] | None) -> Any:
    """Return the shipped network on OpenVINO."""
    import openvino

    core = openvino.Core()
    model = core.read_model(model_path("aqua_yolo11n.onnx"))
    if shape is not None:
        model.reshape(shape)
    options = {"INFERENCE_NUM_THREADS": threads, "NUM_STREAMS": streams}
    return core.compile_model(model, "CPU", options)


def requests() -> dict[str, Callable[[], Any]]:
    """One request with one or two threads, two requests at a time, and a fixed input size."""
    image = tensor(INPUT, np.float32)
    shape = [1, 3, 736, 1280]
    one = network(1, 1, None).create_infer_request()
    fixed = network(1, 1, shape).create_infer_request()
    both = network(2, 1, shape).create_infer_request()
    streams = network(2, 2, shape)
    pair = [streams.create_infer_request() for _ in range(2)]

    def at_once() -> None:
        for request in pair:
            request.start_async({0: image}, share_inputs=True)
        for request in pair:
            request.wait()

    return {
        "any size, one thread": lambda: one.infer({0: image}, share_inputs=True),
        "1280x736 only, one thread": lambda: fixed.infer({0: image}, share_inputs=True),
        "1280x736 only, two threads": lambda: both.infer({0: image}, share_inputs=True),
        "two at once, a thread each (two images)": at_once,
    }


def windows() -> dict[str, Callable[[], Any]]:
    """Three robots' windows and a part, as `search.mode` roi has them, in several ways."""
    window, part = [1, 3, 128, 128], [1, 3, 288, 320]
    images = {
        tuple(shape): tensor(INPUT[: shape[2], : shape[3]], np.float32) for shape in (window, part)
    }
    small, large = (images[tuple(shape)] for shape in (window, part))
    three = np.repeat(small, 3, axis=0)
    own = {
        threads: [network(threads, 1, s).create_infer_request() for s in (window, part)]
        for threads in (1, 2)
    }
    together = network(2, 1, [3, *window[1:]]).create_infer_request()
    anything = network(2, 1, None).create_infer_request()

    def in_turn(threads: int) -> None:
        for _ in range(3):
            own[threads][0].infer({0: small}, share_inputs=True)
        own[threads][1].infer({0: large}, share_inputs=True)

    def beside() -> None:
        own[1][1].start_async({0: large}, share_inputs=True)
        for _ in range(3):
            own[1][0].infer({0: small}, share_inputs=True)
        own[1][1].wait()

    def batch(request: Any, rest: Any) -> None:
        request.infer({0: three}, share_inputs=True)
        rest.infer({0: large}, share_inputs=True)

    return {
        "three windows and a part, in turn, two threads": lambda: in_turn(2),
        "in turn, one thread": lambda: in_turn(1),
        "the part beside the windows, a thread each": beside,
        "the windows as a batch of three, then the part": lambda: batch(together, own[2][1]),
        "the same, compiled for any size": lambda: batch(anything, anything),
    }


def conversions() -> dict[str, Callable[[], Any]]:
    """What comes before the network on ONNX Runtime, and decoding."""
    large = cv2.resize(PICTURE, (3840, 2160))
    small_jpeg, large_jpeg = (cv2.imencode(".jpg", image)[1] for image in (PICTURE, large))
    half = cv2.IMREAD_REDUCED_COLOR_2

    def shrunk(flag: int) -> Any:
        image = cv2.imdecode(large_jpeg, flag)
        return cv2.resize(image, (1280, 720), interpolation=cv2.INTER_AREA)

    return {
        "bytes to ONNX Runtime's input": lambda: tensor(INPUT, np.float32),
        "JPEG 720p": lambda: cv2.imdecode(small_jpeg, cv2.IMREAD_COLOR),
        "JPEG 4K, shrunk to 1280": lambda: shrunk(cv2.IMREAD_COLOR),
        "JPEG 4K read at half size, shrunk to 1280": lambda: shrunk(half),
    }


def main() -> None:
    """Print the tables."""
    cv2.setNumThreads(1)
    for works in (requests(), windows(), conversions()):
        print("| work | ms |\n|---|---|")
        for name, milliseconds in medians(works).items():
            print(f"| {name} | {milliseconds:.1f} |")
        print()


if __name__ == "__main__":
    main()
