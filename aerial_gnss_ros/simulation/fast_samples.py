# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labelled images of random scenes from the simulation's own renderer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from aerial_gnss_ros.simulation.filling import Stage, random_stage
from aerial_gnss_ros.simulation.labels import RobotLabel
from aerial_gnss_ros.simulation.planes import U8
from aerial_gnss_ros.simulation.renderer import Renderer
from aerial_gnss_ros.simulation.samples import DatasetConfig, Sample, labelled, moved
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
            about = {
                "height_m": round(stage.height, 3),
                "tilt_deg": round(float(np.degrees(stage.tilt)), 2),
                "wind_mps": round(scene.wind_speed, 2),
                "sun_elevation_deg": round(float(np.degrees(scene.sun_elevation)), 1),
                "sun_light": round(scene.sun_light, 3),
            }
            yield Sample(image, [moved(label, stage.window) for label in labels], about)

    def _picture(self, renderer: Renderer, stage: Stage, t_s: float) -> tuple[U8, list[RobotLabel]]:
        """The rendered stage; with `prune`, without the robots that cannot be labelled."""
        robots = stage.robots
        for _ in range(4):
            image, labels = renderer.render(
                stage.camera, stage.pose, t_s, robots, stage.props, stage.window
            )
            good = {label.robot_id for label in labels if labelled(label)}
            if not self._config.prune or len(good) == len(robots):
                break
            robots = [robot for robot in robots if robot.robot_id in good]
        return image, labels
