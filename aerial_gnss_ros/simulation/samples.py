# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labelled images of random scenes: what to render, and what a renderer gives."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from aerial_gnss_ros.simulation.hexapod import RobotState
from aerial_gnss_ros.simulation.labels import RobotLabel
from aerial_gnss_ros.simulation.planes import U8
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.staging import Variety
from aerial_gnss_ros.simulation.view import Window

# Labelled for training: a little more than what a detector is scored on (labels.py).
LEAST_CONTRAST = 0.05
LEAST_LONG_PX = 10.0
LEAST_VISIBLE_CROP = 0.4
_MOST_RENDERINGS = 4  # of one image, without the robots that cannot be labelled


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
        renderer: See `sample_source`.
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


def labelled(label: RobotLabel) -> bool:
    """Return whether a robot gets a box to train on."""
    return (
        label.contrast >= LEAST_CONTRAST
        and label.visible >= LEAST_VISIBLE_CROP
        and label.long_px >= LEAST_LONG_PX
    )


def only_labelled(
    render: Callable[[list[RobotState]], tuple[U8, list[RobotLabel]]], robots: list[RobotState]
) -> tuple[U8, list[RobotLabel]]:
    """Return an image without the robots that cannot be labelled, and the labels of the others.

    Args:
        render: returns the image of some robots, and their labels.
        robots: to begin with.
    """
    for _ in range(_MOST_RENDERINGS):
        image, labels = render(robots)
        good = {label.robot_id for label in labels if labelled(label)}
        if len(good) == len(robots):
            break
        robots = [robot for robot in robots if robot.robot_id in good]
    return image, labels


def view_data(scene: Scene, height_m: float, tilt_rad: float) -> dict[str, float]:
    """Return `Sample.about` of an image.

    Args:
        scene: light and sea.
        height_m: of the camera above the water, m.
        tilt_rad: of the camera from straight down, rad.
    """
    return {
        "height_m": round(height_m, 3),
        "tilt_deg": round(float(np.degrees(tilt_rad)), 2),
        "wind_mps": round(scene.wind_speed, 2),
        "sun_elevation_deg": round(float(np.degrees(scene.sun_elevation)), 1),
        "sun_light": round(scene.sun_light, 3),
    }


def moved(label: RobotLabel, window: Window) -> RobotLabel:
    """Return a label in pixels of the window instead of the whole image."""
    x, y = window.x, window.y
    pixel = (label.pixel[0] - x, label.pixel[1] - y)
    return replace(
        label, left=label.left - x, top=label.top - y, right=label.right - x,
        bottom=label.bottom - y, pixel=pixel,
    )  # fmt: skip
