# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Blender's process may die, and bpy may be missing; neither shows a traceback."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ConfigError, OutputError
from aerial_gnss_ros.simulation.blender import samples
from aerial_gnss_ros.simulation.sample_source import sample_source
from aerial_gnss_ros.simulation.samples import DatasetConfig, Sample

# Stands in for the worker: dies at its first order (or at every one), then answers.
STAND_IN = """
import os, pathlib, sys
import numpy as np
from aerial_gnss_ros.simulation.blender.worker import receive, send
from aerial_gnss_ros.simulation.samples import Sample
order = receive(sys.stdin.buffer)
mark = pathlib.Path(sys.argv[1])
if sys.argv[2] == "always" or not mark.exists():
    mark.touch()
    os.abort()
image = np.full((2, 3, 3), order.seed[0] % 256, np.uint8)
send(sys.stdout.buffer, Sample(image, [], {}))
"""


@pytest.fixture
def config(monkeypatch) -> DatasetConfig:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: name)
    return DatasetConfig({}, renderer="blender")


def _stand_in(monkeypatch, mark: Path, dies: str) -> None:
    command = [sys.executable, "-c", STAND_IN, str(mark), dies]
    monkeypatch.setattr(samples, "_BLENDER", samples.Blender(command))


def test_a_crash_of_blender_loses_nothing(monkeypatch, tmp_path: Path, config) -> None:
    """The picture is made again by a new process, from the same order."""
    _stand_in(monkeypatch, tmp_path / "mark", "once")
    rng = np.random.default_rng(4)
    (sample,) = sample_source(config).samples(rng, 1)
    first = int(np.random.default_rng(4).integers(2**32, size=4)[0])
    assert isinstance(sample, Sample)
    assert (sample.image == first % 256).all()


def test_a_picture_that_always_crashes_is_named(monkeypatch, tmp_path: Path, config) -> None:
    """By its seed, with the status of the process."""
    _stand_in(monkeypatch, tmp_path / "mark", "always")
    with pytest.raises(OutputError, match=r"seed \(\d+, .*ended with status -6"):
        list(sample_source(config).samples(np.random.default_rng(0), 1))


@pytest.mark.parametrize(
    ("version", "words"),
    [((3, 11), r'pip install "\.\[blender\]"'), ((3, 12), "this is Python 3.12")],
)
def test_without_bpy_the_sentence_says_what_to_do(monkeypatch, version, words: str) -> None:
    """It depends on whether this Python can have it."""
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    monkeypatch.setattr(samples, "PYTHON", version)
    with pytest.raises(ConfigError, match=words):
        sample_source(DatasetConfig({}, renderer="blender"))


def test_ranges_that_do_not_exist_are_refused(monkeypatch) -> None:
    """With the names that do."""
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: name)
    with pytest.raises(ConfigError, match="'mars'; choose one of train, unseen"):
        sample_source(DatasetConfig({}, renderer="blender", ranges="mars"))
