# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Camera images of robots at sea, rendered through the true camera geometry, with their labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.simulation.composite import (
    Body,
    contrasts,
    merged,
    paint_above,
    paint_below,
    slices,
)
from aerial_gnss_ros.simulation.develop import Developer
from aerial_gnss_ros.simulation.hexapod import RobotState
from aerial_gnss_ros.simulation.labels import RobotLabel, box_of_points, turned_size
from aerial_gnss_ros.simulation.mesh import Mesh
from aerial_gnss_ros.simulation.planes import F32, U8, split, transform
from aerial_gnss_ros.simulation.raster import Layer, body_window, draw
from aerial_gnss_ros.simulation.robot_models import placed_robot
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.shading import Effect, Shader, Water
from aerial_gnss_ros.simulation.view import ViewPose, Window, optical_rays, project_points
from aerial_gnss_ros.simulation.wash import disturb, reach_points, wobble

STRIP_ROWS = 40
"""Rows shaded at a time: the planes of a strip then stay in the processor's cache."""
COARSE = 40
"""px between the rays that set the exposure."""


def noise_seed(t_s: float, part: Window) -> int:
    """Return the seed of the sensor noise of a part of the image at a time."""
    return abs(round(t_s * 1e6)) * 4096 + part.x + 64 * part.y


class Renderer:
    """Renders one scene.

    The same scene, camera, pose, time and robots give the same bytes, whatever was rendered before
    and in whichever process.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._shader = Shader(scene)
        self._developer = Developer(scene)
        self._rays: tuple[CameraModel, Window, F32] | None = None

    def render(
        self,
        camera: CameraModel,
        pose: ViewPose,
        t_s: float,
        robots: Sequence[RobotState],
        props: Sequence[Mesh] = (),
        window: Window | None = None,
    ) -> tuple[U8, list[RobotLabel]]:
        """Renders an image.

        Args:
            camera: Lens and image size.
            pose: Of the camera.
            t_s: Time of the scene in seconds: moves the waves and seeds the noise.
            robots: To be drawn.
            props: Other things in local ENU, drawn without label.
            window: Renders only these pixels of the camera's image.

        Returns:
            Image (height, width, 3) uint8, blue green red, of the window (or all), and a label for
            each robot of which anything is in it; labels are in pixels of the *whole* image.
        """
        whole = Window(0, 0, camera.width, camera.height)
        part = whole if window is None else window
        size = (camera.width, camera.height)
        self._shader.sea.set_time(t_s)
        angle = self._pixel_angle(camera)
        gain = self._gain(camera, pose, angle)
        rays = self._window_rays(camera, part)
        rotation = pose.enu_from_optical.astype(np.float32)
        planes = self._sea(rays, rotation, pose, angle)
        bodies = self._bodies(camera, pose, robots, props, part)
        contrast: dict[str, float] = {}
        for area in self._areas(camera, pose, robots, bodies, part):
            inner = Window(area.x - part.x, area.y - part.y, area.width, area.height)
            rows = slice(inner.y, inner.y + inner.height)
            columns = slice(inner.x, inner.x + inner.width)
            before = [p[rows, columns] for p in planes]
            block = self._directions(rays[rows, columns], rotation)
            effects = self._effects(bodies, robots, area, pose, angle)
            after = self._shader.shade(block, pose.position, angle, effects)
            for body in bodies:
                paint_above(after, body.layer, area)
            clean = self._developer.tone(before, gain, area, size)
            dirty = self._developer.tone(after, gain, area, size)
            contrast.update(contrasts(bodies, area, clean, dirty))
            for plane, new in zip(planes, after, strict=True):
                plane[rows, columns] = new
        image = self._developer.tone(planes, gain, part, size)
        image = self._developer.finish(image, noise_seed(t_s, part))
        labels = [
            label
            for body in bodies
            if (label := self._label(body, camera, pose, part, contrast)) is not None
        ]
        return image, sorted(labels, key=lambda label: label.robot_id)

    @staticmethod
    def _pixel_angle(camera: CameraModel) -> float:
        return float(2.0 / (camera.K[0, 0] + camera.K[1, 1]))

    def _gain(self, camera: CameraModel, pose: ViewPose, angle: float) -> float:
        """Automatic exposure from a coarse grid over the whole image."""
        columns, rows = -(-camera.width // COARSE), -(-camera.height // COARSE)
        u = (np.arange(columns) + 0.5) * camera.width / columns - 0.5
        v = (np.arange(rows) + 0.5) * camera.height / rows - 0.5
        grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
        rays, valid = camera.rays(grid)
        rays = np.where(valid[:, None], rays, (0.0, 0.0, 1.0)).astype(np.float32)
        coarse = np.ascontiguousarray(rays.reshape(len(v), len(u), 3))
        directions = self._directions(coarse, pose.enu_from_optical.astype(np.float32))
        light = self._shader.shade(directions, pose.position, angle * COARSE)
        return self._developer.gain(light)

    def _window_rays(self, camera: CameraModel, window: Window) -> F32:
        if self._rays is None or self._rays[0] is not camera or self._rays[1] != window:
            self._rays = (camera, window, optical_rays(camera, window))
        return self._rays[2]

    @staticmethod
    def _directions(rays: F32, rotation: F32) -> list[F32]:
        return split(transform(rays, rotation))

    def _sea(self, rays: F32, rotation: F32, pose: ViewPose, angle: float) -> list[F32]:
        height, width = rays.shape[:2]
        planes = [np.empty((height, width), np.float32) for _ in range(3)]
        for row in range(0, height, STRIP_ROWS):
            rows = slice(row, row + STRIP_ROWS)
            light = self._shader.shade(self._directions(rays[rows], rotation), pose.position, angle)
            for plane, strip in zip(planes, light, strict=True):
                plane[rows] = strip
        return planes

    def _bodies(
        self,
        camera: CameraModel,
        pose: ViewPose,
        robots: Sequence[RobotState],
        props: Sequence[Mesh],
        part: Window,
    ) -> list[Body]:
        """Everything that may touch the window, the farthest first."""
        things: list[tuple[Mesh, RobotState | None]] = [(placed_robot(r), r) for r in robots]
        things += [(prop, None) for prop in props]
        bodies = []
        for mesh, state in things:
            window = body_window(camera, pose, mesh)
            if window is None or window.clipped(part) is None:
                continue
            layer = draw(
                camera,
                pose,
                mesh,
                window,
                self.scene,
                self._shader.sun_irradiance,
                self._shader.sky.irradiance,
            )
            distance = float(np.linalg.norm(mesh.vertices.mean(axis=0) - pose.position))
            bodies.append(Body(mesh, state, layer, layer.coverage.copy(), distance))
        bodies.sort(key=lambda b: -b.distance)
        for i, body in enumerate(bodies):
            for nearer in bodies[i + 1 :]:
                overlap = nearer.layer.window.clipped(body.layer.window)
                if overlap is not None:
                    body.visible[slices(overlap, body.layer.window)] *= (
                        1.0 - nearer.layer.coverage[slices(overlap, nearer.layer.window)]
                    )
        return bodies

    def _areas(
        self,
        camera: CameraModel,
        pose: ViewPose,
        robots: Sequence[RobotState],
        bodies: list[Body],
        part: Window,
    ) -> list[Window]:
        """Disjoint windows in which the plain sea changes: bodies, shadows and wakes."""
        areas = [b.layer.window for b in bodies]
        for robot in robots:
            pixels, valid = project_points(camera, pose, reach_points(robot, self.scene))
            if valid.all():
                low, high = np.floor(pixels.min(axis=0)), np.ceil(pixels.max(axis=0))
                span = np.clip(np.concatenate([low, high]), -1e6, 1e6).astype(int)
                areas.append(Window(span[0], span[1], span[2] - span[0] + 1, span[3] - span[1] + 1))
        clipped = [w for a in areas if (w := a.clipped(part)) is not None]
        return merged(clipped)

    def _effects(
        self,
        bodies: list[Body],
        robots: Sequence[RobotState],
        area: Window,
        pose: ViewPose,
        angle: float,
    ) -> Effect:
        def apply(water: Water) -> None:
            for robot in robots:
                disturb(water, robot, self.scene)
            for body in bodies:
                depth = max(-float(body.mesh.vertices[:, 2].mean()), 0.0)
                # A wave's slope bends the sight line by a quarter of it (1 - 1/1.34).
                gain = 0.25 * depth / (body.distance * angle)
                paint_below(water.glow, self._wobbled(body, area, water, pose, gain), area)

        return apply

    @staticmethod
    def _wobbled(body: Body, area: Window, water: Water, pose: ViewPose, gain: float) -> Layer:
        overlap = body.layer.window.clipped(area)
        if overlap is None or gain < 0.5:
            return body.layer
        inside = slices(overlap, area)
        east = water.waves.slope_east[inside]
        north = water.waves.slope_north[inside]
        axes = pose.enu_from_optical
        right = east * np.float32(axes[0, 0]) + north * np.float32(axes[1, 0])
        down = east * np.float32(axes[0, 1]) + north * np.float32(axes[1, 1])
        here = slices(overlap, body.layer.window)
        moved = []
        for layer in (body.layer.below, body.layer.hidden):
            copy = layer.copy()
            copy[here] = wobble(np.ascontiguousarray(layer[here]), right, down, gain)
            moved.append(copy)
        return replace(body.layer, below=moved[0], hidden=moved[1])

    def _label(
        self,
        body: Body,
        camera: CameraModel,
        pose: ViewPose,
        part: Window,
        contrast: dict[str, float],
    ) -> RobotLabel | None:
        state = body.state
        if state is None or state.robot_id not in contrast:
            return None
        pixels, _ = project_points(camera, pose, body.mesh.vertices)
        box = box_of_points(pixels, part)
        overlap = body.layer.window.clipped(part)
        if box is None or overlap is None:
            return None
        total = float(body.layer.coverage.sum())
        seen = float(body.visible[slices(overlap, body.layer.window)].sum())
        if seen < 0.5:
            return None
        long_px, short_px = turned_size(pixels)
        middle, _ = project_points(camera, pose, np.array([[state.east, state.north, 0.0]]))
        return RobotLabel(
            state.robot_id, state.class_name, *box, long_px, short_px, state.depth,
            contrast[state.robot_id], seen / total, (float(middle[0, 0]), float(middle[0, 1])),
        )  # fmt: skip
