# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labelled images from Blender, which runs in a separate process because it may crash."""

from __future__ import annotations

import atexit
import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterator

import numpy as np

from aerial_gnss_ros.core.values.errors import ConfigError, OutputError
from aerial_gnss_ros.resources import install_hint
from aerial_gnss_ros.simulation.blender import worker
from aerial_gnss_ros.simulation.blender.picture import Order
from aerial_gnss_ros.simulation.blender.ranges import ranges_named
from aerial_gnss_ros.simulation.samples import DatasetConfig, Sample

PYTHON = sys.version_info[:2]
TRIES = 2
"""Attempts per image: Blender's crashes are often random, but not twice on the same image."""


def require_blender() -> None:
    """Raise an error if bpy is not installed.

    Raises:
        ConfigError: it is not.
    """
    if importlib.util.find_spec("bpy") is not None:
        return
    raise ConfigError(
        "the renderer blender needs bpy 5.0, which exists for Python 3.11 only; "
        + (
            f"install it with {install_hint('blender')}."
            if PYTHON == (3, 11)
            else f"this is Python {PYTHON[0]}.{PYTHON[1]}: use an environment of 3.11, or the "
            "renderer fast."
        )
    )


class BlenderSource:
    """Pictures of Blender's Cycles, with the ranges that the configuration names.

    Raises:
        ConfigError: bpy is not installed, or there are no ranges of that name.
    """

    def __init__(self, config: DatasetConfig) -> None:
        require_blender()
        ranges_named(config.ranges)
        self._config = config

    def samples(self, rng: np.random.Generator, count: int) -> Iterator[Sample]:
        """Yield `count` pictures, each of a scene of its own.

        Raises:
            OutputError: Blender crashed or failed twice on the same image.
        """
        for _ in range(count):
            seed = tuple(int(x) for x in rng.integers(2**32, size=4))
            yield _rendered(Order(seed, self._config))


def _rendered(order: Order) -> Sample:
    answer: Sample | str = ""
    for _ in range(TRIES):
        answer = _BLENDER.ask(order)
        if isinstance(answer, Sample):
            return answer
        _BLENDER.close()
    raise OutputError(f"Blender could not render the image of seed {order.seed}: {answer}")


class Blender:
    """The process, started when it is first needed.

    Args:
        command: starts it.
    """

    def __init__(self, command: list[str]) -> None:
        self._command = command
        self._process: subprocess.Popen[bytes] | None = None

    def ask(self, order: Order) -> Sample | str:
        """Return the image, or a sentence on why there is none."""
        process = self._process or self._start()
        if process.stdin is None or process.stdout is None:
            raise RuntimeError("the process was started without pipes.")
        try:
            worker.send(process.stdin, order)
            answer: Sample | str = worker.receive(process.stdout)
        except (EOFError, OSError):
            process.wait()
            return f"its process ended with status {process.returncode}."
        return answer

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def _start(self) -> subprocess.Popen[bytes]:
        # One thread: many images are distributed better over processes than one over threads.
        environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        self._process = subprocess.Popen(  # noqa: S603  (our own module)
            self._command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=environment,
        )
        return self._process


_BLENDER = Blender([sys.executable, "-m", worker.__name__])
atexit.register(_BLENDER.close)
