# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a model compiled for one image size costs and gains on OpenVINO: docs/results/detection.md.

    python benchmarks/compiled_sizes.py

Memory is what the process holds more after each step (anonymous, after a trim), MB; time is what
one thread of the processor worked, ms, medians taken in turns. Neither depends much on what else
runs. How long an image takes beside other programs is measured with one of them for each core.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.nodes.memory import give_freed_memory_back
from aerial_gnss_ros.resources import model_path

WHOLE, WINDOW, PART = (1280, 736), (128, 128), (320, 288)
FREE = {"ENABLE_CPU_PINNING": False}


class Models:
    """Compiles the shipped network for a size, or for any."""

    def __init__(self) -> None:
        import openvino

        self._core = openvino.Core()
        self._model = self._core.read_model(model_path("aqua_yolo11n.onnx"))

    def __call__(self, size: tuple[int, int] | None, **options: Any) -> Any:
        """Return what runs images of a size, px; None: of any."""
        model = self._model.clone()
        if size is not None:
            model.reshape([1, 3, size[1], size[0]])
        given = {"PERFORMANCE_HINT": "LATENCY", **options}
        return self._core.compile_model(model, "CPU", given).create_infer_request()


def run(request: Any, size: tuple[int, int]) -> None:
    """Run one image of a size, px."""
    request.infer({0: np.zeros((1, 3, size[1], size[0]), np.float32)})


def held_mb() -> float:
    """Return the memory that the process holds."""
    give_freed_memory_back()
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("RssAnon"))


def memory() -> Iterator[tuple[str, float]]:
    """Give each step and what it adds, MB; each way to run whole images in a process of its own."""
    for name, steps in (
        ("own size", [(WHOLE, WHOLE), (WINDOW, WINDOW), (PART, PART), (None, WINDOW)]),
        ("any size", [(None, WINDOW), (None, WHOLE)]),
    ):
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            for (compiled, size), more in zip(steps, pool.apply(_added, (steps,)), strict=True):
                kind = "any size" if compiled is None else "its own size"
                yield f"{name} first: {size[0]}x{size[1]}, compiled for {kind}", more


def _added(steps: list[tuple[Any, tuple[int, int]]]) -> list[float]:
    models, kept, added = Models(), {}, []
    for compiled, size in steps:
        before = held_mb()
        if compiled not in kept:
            kept[compiled] = models(compiled)
        run(kept[compiled], size)
        added.append(held_mb() - before)
    return added


def times(models: Models, rounds: int = 21) -> Iterator[tuple[str, float]]:
    """Give processor times of one thread, ms."""
    one = {"INFERENCE_NUM_THREADS": 1, **FREE}
    own, free = {size: models(size, **one) for size in (WINDOW, PART)}, models(None, **one)
    spent: dict[str, list[float]] = {}
    for _ in range(rounds):
        for words, size, request, repeated in (
            *(("own size", size, own[size], 1) for size in own),
            *(("any size, sizes in turn", size, free, 1) for size in own),
            *(("any size, the same again", size, free, 2) for size in own),
        ):
            for _ in range(repeated):
                started = time.process_time()
                run(request, size)
                taken = 1e3 * (time.process_time() - started)
            spent.setdefault(f"{size[0]}x{size[1]}, {words}", []).append(taken)
    yield from ((name, float(np.median(values))) for name, values in spent.items())


def waits(models: Models, rounds: int = 60) -> Iterator[tuple[str, float]]:
    """Give how long a window takes with a busy program for each core, ms, median and p95."""
    ways = {"bound to cores": models(WINDOW), "not bound": models(WINDOW, **FREE)}
    spent: dict[str, list[float]] = {name: [] for name in ways}
    with busy():
        for _ in range(rounds):
            for name, request in ways.items():
                started = time.perf_counter()
                run(request, WINDOW)
                spent[name].append(1e3 * (time.perf_counter() - started))
                time.sleep(0.01)  # the next image is not there yet
    for name, values in spent.items():
        yield f"threads {name}, median", float(np.median(values))
        yield f"threads {name}, p95", float(np.percentile(values, 95))


@contextmanager
def busy() -> Iterator[None]:
    """Keep each core busy."""
    context = multiprocessing.get_context("spawn")
    others = [context.Process(target=_work, daemon=True) for _ in range(os.cpu_count() or 1)]
    for other in others:
        other.start()
    try:
        time.sleep(1.0)
        yield
    finally:
        for other in others:
            other.terminate()
            other.join()


def _work() -> None:
    while True:
        sum(range(10_000))


def main() -> None:
    """Print the tables."""
    models = Models()
    for unit, rows in (("MB", memory()), ("ms", times(models)), ("ms", waits(models))):
        print(f"| what | {unit} |\n|---|---|")
        for name, value in rows:
            print(f"| {name} | {value:.1f} |", flush=True)
        print()


if __name__ == "__main__":
    main()
