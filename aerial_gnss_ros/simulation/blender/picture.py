# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One labelled image: build, render, label, develop. Needs bpy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aerial_gnss_ros.simulation.blender import nodes, studio
from aerial_gnss_ros.simulation.blender.ranges import ranges_named
from aerial_gnss_ros.simulation.blender.shot import Shot, random_shot
from aerial_gnss_ros.simulation.blender.tracing import Outline, Tracer, box, in_window
from aerial_gnss_ros.simulation.develop import Developer
from aerial_gnss_ros.simulation.labels import RobotLabel, turned_size
from aerial_gnss_ros.simulation.planes import U8
from aerial_gnss_ros.simulation.samples import DatasetConfig, Sample, labelled, view_data
from aerial_gnss_ros.simulation.view import Window, project_points

PAD_PX = 6
"""Margin around the boxes for rendering the image without robots."""


@dataclass(frozen=True)
class Order:
    """Specification of an image; the same order gives the same image.

    Attributes:
        seed: integers that determine everything random.
        config: what to draw from.
    """

    seed: tuple[int, ...]
    config: DatasetConfig


def render_sample(order: Order, folder: Path) -> Sample:
    """Makes a picture.

    Args:
        order: its specification.
        folder: for temporary files.
    """
    config = order.config
    rng = np.random.default_rng(order.seed)
    shot = random_shot(
        rng, ranges_named(config.ranges), config.size, config.occupied, config.image, config.variety
    )
    built = studio.build(shot, config.samples, int(rng.integers(2**31)))
    camera = _Camera(built, folder)
    tracer = Tracer(built)
    found = {name: tracer.outline(name) for name in built.robots}
    outlines = {name: outline for name, outline in found.items() if outline is not None}
    picture = camera.expose()
    labels = _labels(built, camera, outlines, picture)
    good = {label.robot_id for label in labels if labelled(label)}
    if config.prune and len(good) < len(built.robots):
        # Including robots out of view: their shadows or reflections may be visible.
        studio.hide([things for name, things in built.robots.items() if name not in good])
        picture = camera.expose()
        labels = [label for label in labels if label.robot_id in good]
    image = camera.developer.finish(picture, int(rng.integers(2**31)))
    about = view_data(shot.scene, shot.view.height, shot.view.tilt)
    return Sample(image, labels, about)


class _Camera:
    """Renders and develops pictures of one shot with the exposure of the first."""

    def __init__(self, built: studio.Set, folder: Path) -> None:
        shot = built.shot
        self._built = built
        self.developer = Developer(shot.scene)
        window = shot.view.window
        self._size = (window.width, window.height)
        self._frame = Window(0, 0, window.width, window.height)
        self._white = np.float32(nodes.daylight(shot))
        self._folder = folder
        self._gain: float | None = None

    def expose(self, part: Window | None = None) -> U8:
        light = studio.render(self._built, self._folder, part) / self._white
        planes = [np.ascontiguousarray(light[..., i]) for i in range(3)]
        if self._gain is None:
            self._gain = self.developer.gain(planes)
        return self.developer.tone(planes, self._gain, part or self._frame, self._size)


def _labels(
    built: studio.Set, camera: _Camera, outlines: dict[str, Outline], picture: U8
) -> list[RobotLabel]:
    """Labels of the robots in the picture; leaves the robots visible."""
    area = _area(outlines, built.shot.view.window)
    if area is None:
        return []
    robots = list(built.robots.values())
    studio.hide(robots)
    without = camera.expose(area)
    studio.hide(robots, hidden=False)
    made = [
        _label(name, outline, built.shot, picture, without, area)
        for name, outline in outlines.items()
    ]
    return [label for label in made if label is not None]


def _area(outlines: dict[str, Outline], window: Window) -> Window | None:
    """Smallest window around all visible robots, in pixels of the image."""
    boxes = np.array([b for o in outlines.values() if (b := box(o, window)) is not None])
    if not len(boxes):
        return None
    corner = np.array([window.x, window.y])
    size = np.array([window.width, window.height])
    low = np.floor(boxes[:, :2].min(axis=0) - corner - PAD_PX).astype(int)
    high = np.ceil(boxes[:, 2:].max(axis=0) - corner + PAD_PX).astype(int) + 1
    low, high = np.maximum(low, 0), np.minimum(high, size)
    return Window(int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1]))


def _label(
    name: str, outline: Outline, shot: Shot, picture: U8, without: U8, area: Window
) -> RobotLabel | None:
    window = shot.view.window
    edges = box(outline, window)
    if edges is None:
        return None
    inside = in_window(outline.pixels, window)
    local = outline.pixels[inside] - [window.x, window.y]
    columns, rows = np.unique(np.round(local).astype(int), axis=0).T
    keep = (columns >= area.x) & (columns < area.x + area.width)
    keep &= (rows >= area.y) & (rows < area.y + area.height)
    columns, rows = columns[keep], rows[keep]
    here = picture[rows, columns].astype(np.float64)
    there = without[rows - area.y, columns - area.x].astype(np.float64)
    long_px, short_px = turned_size(outline.pixels)
    robot = next(r for r in shot.robots if r.robot_id == name)
    pixel, _ = project_points(
        shot.view.camera, shot.view.pose, np.array([[robot.east, robot.north, 0.0]])
    )
    left, top, right, bottom = edges
    return RobotLabel(
        name, robot.class_name,
        left - window.x, top - window.y, right - window.x, bottom - window.y,
        long_px + outline.step, short_px + outline.step, robot.depth,
        float(np.abs(here - there).mean() / 255.0) if len(here) else 0.0,
        float((inside & outline.free).mean()),
        (float(pixel[0, 0]) - window.x, float(pixel[0, 1]) - window.y),
    )  # fmt: skip
