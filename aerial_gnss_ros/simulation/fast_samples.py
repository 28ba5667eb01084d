# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labelled images of random scenes from the simulation's own renderer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from aerial_gnss_ros.simulation.filling import Stage, random_stage
from aerial_gnss_ros.simulation.hexapod import RobotState
from aerial_gnss_ros.simulation.labels import RobotLabel
from aerial_gnss_ros.simulation.planes import U8
from aerial_gnss_ros.simulation.renderer import Renderer
from aerial_gnss_ros.simulation.samples import (
    DatasetConfig,
    Sample,
    moved,
    only_labelled,
    view_data,
)
from aerial_gnss_ros.simulation.scene import random_scene, with_wind

_MOVING = 0.3  # share of scenes with motion blur
_MOTION_PX = 2.0


class FastSource:
    """Images of the simulation's own renderer (renderer.py)."""

    def __init__(self, config: DatasetConfig) -> None:
        self._config = config

    def samples(self, rng: np.random.Generator, count: int) -> Iterator[Sample]:
        """Yield `count` images of one random scene."""
        scene = random_scene(rng)
        if rng.random() < _MOVING:
            motion = rng.normal(0.0, _MOTION_PX, 2)
            scene = replace(scene, motion_px=(float(motion[0]), float(motion[1])))
        config = self._config
        scene = with_wind(rng, scene, config.variety.wind_mps)
        renderer = Renderer(scene)
        for _ in range(count):
            stage = random_stage(rng, config.size, config.occupied, config.image, config.variety)
            image, labels = self._picture(renderer, stage, float(rng.uniform(0.0, 600.0)))
            about = view_data(scene, stage.height, stage.tilt)
            yield Sample(image, [moved(label, stage.window) for label in labels], about)

    def _picture(self, renderer: Renderer, stage: Stage, t_s: float) -> tuple[U8, list[RobotLabel]]:
        """The rendered stage; with `prune`, without the robots that cannot be labelled."""

        def render(robots: list[RobotState]) -> tuple[U8, list[RobotLabel]]:
            return renderer.render(stage.camera, stage.pose, t_s, robots, stage.props, stage.window)

        if self._config.prune:
            return only_labelled(render, stage.robots)
        return render(stage.robots)
