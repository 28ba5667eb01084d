# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labelled images of random scenes: their specification, and the fast renderer as a source."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.filling import Stage, random_stage
from aerial_gnss_ros.simulation.labels import RobotLabel
from aerial_gnss_ros.simulation.planes import U8
from aerial_gnss_ros.simulation.renderer import Renderer
from aerial_gnss_ros.simulation.scene import random_scene, with_wind
from aerial_gnss_ros.simulation.staging import Variety
from aerial_gnss_ros.simulation.view import Window

# Labelled for training: a little more than what a detector is scored on (labels.py).
LEAST_CONTRAST = 0.05
LEAST_LONG_PX = 10.0
LEAST_VISIBLE_CROP = 0.4
RENDERERS = ("fast", "blender")
_MOVING = 0.3  # share of scenes with motion blur
_MOTION_PX = 2.0


@dataclass(frozen=True)
class DatasetConfig:
    """What to render.

    Attributes:
        counts: Images per split name.
        size: Width and height of the crops; None for whole frames of `image` size.
        seed: Same seed, same bytes. Splits never share a scene.
        occupied: Share of images that have robots.
        image: Camera size in px, None to vary.
        prune: Whether robots that cannot be labelled (too small, too faint, truncated) are removed
            from the image, so that every visible robot is labelled. Otherwise they stay, and are
            listed in meta.csv with `labelled` 0.
        variety: Ranges of view, robots and other things. Light, sea, blur and exposure vary as
            `scene.random_scene` draws them.
        renderer: One of `RENDERERS`.
        ranges: Name of the Blender renderer's ranges (blender/ranges.py); the fast one has none.
        samples: Paths per pixel and layer in Blender, before denoising.
    """

    counts: dict[str, int]
    size: tuple[int, int] | None = (320, 320)
    seed: int = 0
    occupied: float = 0.8
    image: tuple[int, int] | None = None
    prune: bool = True
    variety: Variety = field(default_factory=Variety)
    renderer: str = "fast"
    ranges: str = "train"
    samples: int = 4


@dataclass(frozen=True)
class Sample:
    """One image and its truth.

    Attributes:
        image: (height, width, 3) uint8, blue, green, red.
        labels: Of every robot that is at least partly visible, in pixels of `image`, whose first
            pixel has its centre at (0, 0).
        about: Data of the image for meta.csv: height_m, tilt_deg, wind_mps, sun_elevation_deg,
            sun_light.
    """

    image: U8
    labels: list[RobotLabel]
    about: dict[str, float]


class SampleSource(Protocol):
    """Renders images of random scenes."""

    def samples(self, rng: np.random.Generator, count: int) -> Iterator[Sample]:
        """Yield `count` images of one random scene.

        The generator alone determines them: the same state gives the same images in any process.
        """


def sample_source(config: DatasetConfig) -> SampleSource:
    """Return the renderer that `config` names.

    Raises:
        ConfigError: no renderer of that name, or its extra is not installed.
    """
    if config.renderer == "fast":
        return FastSource(config)
    if config.renderer == "blender":
        from aerial_gnss_ros.simulation.blender.samples import BlenderSource

        return BlenderSource(config)
    raise ConfigError(
        f"there is no renderer {config.renderer!r}; choose one of {', '.join(RENDERERS)}."
    )


def labelled(label: RobotLabel) -> bool:
    """Return whether a robot gets a box to train on."""
    return (
        label.contrast >= LEAST_CONTRAST
        and label.visible >= LEAST_VISIBLE_CROP
        and label.long_px >= LEAST_LONG_PX
    )


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


def moved(label: RobotLabel, window: Window) -> RobotLabel:
    """Return a label in pixels of the window instead of the whole image."""
    x, y = window.x, window.y
    pixel = (label.pixel[0] - x, label.pixel[1] - y)
    return replace(
        label, left=label.left - x, top=label.top - y, right=label.right - x,
        bottom=label.bottom - y, pixel=pixel,
    )  # fmt: skip
