# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""All runs of a benchmark: with and without nodes, for a flight and a search mode."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from aerial_gnss_ros.adapters.parameter_files import read
from aerial_gnss_ros.bags.reader import BagReader
from aerial_gnss_ros.benchmarking.figures import (
    Figures,
    cost_of_a_robot,
    live_figures,
    one_process_figures,
    spread,
)
from aerial_gnss_ros.benchmarking.live import Offer, measure, ros, serialise
from aerial_gnss_ros.benchmarking.loop import Loop
from aerial_gnss_ros.benchmarking.machine import Power
from aerial_gnss_ros.benchmarking.one_process import OneProcess, plan_and_estimator
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.values.errors import AerialGnssError, ConfigError
from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.config import DetectorConfig, detector_config
from aerial_gnss_ros.detection.images import decode
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.nodes.schemas import DETECTOR, ESTIMATOR, SCHEMAS

_COMPARED, _TRIED = 50, 3
Progress = Callable[[str, int], AbstractContextManager[Callable[[int], None]]]


@dataclass(frozen=True)
class Setting:
    """Settings common to all runs.

    Attributes:
        frames: images per run.
        rate_hz: of the images through the nodes.
        params: parameter files.
        given: further parameters of the detector.
        starts: number of starts of the nodes in each run.
    """

    frames: int
    rate_hz: float
    params: Sequence[Path] = ()
    given: Mapping[str, str] = field(default_factory=dict)
    starts: int = 1

    def detector(self, **search: str) -> DetectorConfig:
        """Return the detector's configuration.

        Raises:
            ConfigError: a value cannot be used.
        """
        values = read(self.params, SCHEMAS)[DETECTOR] | dict(self.given)
        return detector_config(values | {f"search.{key}": value for key, value in search.items()})


class Suite:
    """Runs the pipeline over one recording.

    Args:
        setting: common to all runs.
        bag: the recording; an open one with raw or compressed images.
        progress: shows how far a run is.

    Raises:
        InputError: the recording lacks a topic.
        ConfigError: a parameter cannot be used.
    """

    def __init__(self, setting: Setting, bag: BagReader, progress: Progress) -> None:
        self._setting, self._bag, self._progress = setting, bag, progress
        self._estimator_config = replace(
            estimator_config(read(setting.params, SCHEMAS)[ESTIMATOR]), state_file=""
        )
        plan, _ = self._plan_and_estimator()
        if plan.image_topic is None:
            raise ConfigError("detections.topic and image.topic are the same.")
        self.images = plan.image_topic
        self._topics = sorted(plan.topics)

    def one_process(self, search: str) -> tuple[Figures, str]:
        """Return the figures without nodes, and the detector in words."""
        detector = load_detector(self._setting.detector(mode=search))
        plan, estimator = self._plan_and_estimator()
        loop = self._loop()
        frames = self._setting.frames
        with self._progress(f"one process, {search}", frames) as report:
            run = OneProcess(plan, estimator, detector, serialise).run(loop, frames, report)
        return one_process_figures(run), detector.name

    def nodes(self, search: str, folder: Path) -> Figures:
        """Return the figures through both nodes.

        Raises:
            RosError: a node ended by itself or detected nothing.
        """
        setting = self._setting
        compressed = self.images.endswith("/compressed")
        transport = "compressed" if compressed else "raw"
        given = [f"search.mode:={search}", f"image.transport:={transport}"]
        given += [f"{key}:={value}" for key, value in setting.given.items()]
        offer = Offer(
            bag=self._bag.paths[0],
            images=self.images,
            topics=self._topics,
            recorded_hz=self._loop().rate_hz,
            rate_hz=setting.rate_hz,
            count=setting.frames,
            starts=setting.starts,
        )
        power = Power()
        with ros(), self._progress(f"both nodes, {search}", setting.frames) as report:
            power.begin()
            live = measure(offer, setting.params, given, folder, report)
            watts = power.end()
        return live_figures(live) | {"power": watts}

    def compared(self, model: str, *, allow_pickle: bool) -> Figures:
        """Return the durations of ultralytics and of this package in full mode for some images.

        Raises:
            AerialGnssError: the model cannot be used, or ultralytics is not installed.
        """
        config = self._setting.detector(mode="full")
        theirs = replace(
            config, model=model, backend="ultralytics", allow_pickle=allow_pickle, second_look="off"
        )
        other, own = load_detector(theirs), load_detector(config)
        loop = self._loop()
        moments = (m for m in loop.moments() if loop.is_image(m))
        images = [decode(m.entry.message(0)) for m in itertools.islice(moments, _COMPARED)]
        return {
            "name": other.name,
            "images": len(images),
            "ms": spread(_times(other, images)),
            "ours_ms": spread(_times(own, images)),
        }

    def _plan_and_estimator(self) -> Any:
        topic = self._setting.detector().image.topic
        return plan_and_estimator(self._bag, self._estimator_config, topic)

    def _loop(self) -> Loop:
        return Loop(self._bag, self._topics, self.images)


def _times(detector: Detector, images: Sequence[Any]) -> list[float]:
    """Return milliseconds for each image after a warm-up."""
    for image in images[:_TRIED]:
        detector.detect(image)
    times = []
    for image in images:
        started = time.perf_counter()
        detector.detect(image)
        times.append(1e3 * (time.perf_counter() - started))
    return times


def costs(runs: Sequence[Figures]) -> list[Figures]:
    """Return the cost of one more robot by search mode, from runs with two numbers of robots."""
    found = []
    known = [run for run in runs if run["robots"] is not None]
    for search in dict.fromkeys(run["search"] for run in known):
        own = sorted(
            (run for run in known if run["search"] == search and run.get("one_process")),
            key=lambda run: int(run["robots"]),
        )
        if len(own) > 1 and own[0]["robots"] != own[-1]["robots"]:
            more = own[-1]["robots"] - own[0]["robots"]
            ms = cost_of_a_robot(own[0]["one_process"], own[-1]["one_process"], more)
            found.append({"search": search, "more_robots": more, "ms": ms})
    return found


def try_comparison(suite: Suite, model: str | None, *, allow_pickle: bool) -> Figures:
    """Return the comparison with ultralytics, or the reason why there is none."""
    if not model:
        return {"skipped": "not requested: give --compare MODEL.pt"}
    try:
        return suite.compared(model, allow_pickle=allow_pickle)
    except AerialGnssError as error:
        return {"skipped": f"skipped: {error}"}
