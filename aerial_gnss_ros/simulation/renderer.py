# SPDX-License-Identifier: Apache-2.0
"""Camera images of robots at sea, rendered through the true camera geometry, with their labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera import CameraModel
from aerial_gnss_ros.simulation.develop import Developer
from aerial_gnss_ros.simulation.hexapod import RobotState, placed_robot
from aerial_gnss_ros.simulation.labels import RobotLabel, box_of_points, turned_size
from aerial_gnss_ros.simulation.mesh import Mesh
from aerial_gnss_ros.simulation.raster import Layer, body_window, draw
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.shading import Effect, Shader, Water
from aerial_gnss_ros.simulation.view import ViewPose, Window, optical_rays, project_points
from aerial_gnss_ros.simulation.wash import disturb, reach_points, wobble

F32 = NDArray[np.float32]

STRIP_ROWS = 40
"""Rows shaded at a time: the planes of a strip then stay in the processor's cache."""
COARSE = 40


@dataclass
class _Body:
    """Something drawn: a robot (with state) or a prop (without)."""

    mesh: Mesh
    state: RobotState | None
    layer: Layer
    visible: F32
    distance: float


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
    ) -> tuple[NDArray[np.uint8], list[RobotLabel]]:
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
        contrasts: dict[str, float] = {}
        for area in self._areas(camera, pose, robots, bodies, part):
            inner = Window(area.x - part.x, area.y - part.y, area.width, area.height)
            rows = slice(inner.y, inner.y + inner.height)
            columns = slice(inner.x, inner.x + inner.width)
            before = [p[rows, columns] for p in planes]
            block = self._directions(rays[rows, columns], rotation)
            effects = self._effects(bodies, robots, area, camera, pose, angle)
            after = self._shader.shade(block, pose.position, angle, effects)
            for body in bodies:
                _paint(after, body.layer, area, above=True)
            clean = self._developer.tone(before, gain, area, size)
            dirty = self._developer.tone(after, gain, area, size)
            contrasts.update(_contrasts(bodies, area, clean, dirty))
            for plane, new in zip(planes, after, strict=True):
                plane[rows, columns] = new
        image = self._developer.tone(planes, gain, part, size)
        seed = abs(int(round(t_s * 1e6))) * 4096 + part.x + 64 * part.y
        image = self._developer.finish(image, seed)
        labels = [
            label
            for body in bodies
            if (label := self._label(body, camera, pose, part, contrasts)) is not None
        ]
        return image, sorted(labels, key=lambda label: label.robot_id)

    @staticmethod
    def _pixel_angle(camera: CameraModel) -> float:
        return float(2.0 / (camera.K[0, 0] + camera.K[1, 1]))

    def _gain(self, camera: CameraModel, pose: ViewPose, angle: float) -> float:
        """Automatic exposure from a coarse grid over the whole image."""
        u = np.arange(COARSE // 2, camera.width, COARSE, dtype=np.float64)
        v = np.arange(COARSE // 2, camera.height, COARSE, dtype=np.float64)
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
        turned: list[F32] = list(cv2.split(cv2.transform(rays, rotation)))
        return turned

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
    ) -> list[_Body]:
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
            bodies.append(_Body(mesh, state, layer, layer.coverage.copy(), distance))
        bodies.sort(key=lambda b: -b.distance)
        for i, body in enumerate(bodies):
            for nearer in bodies[i + 1 :]:
                overlap = nearer.layer.window.clipped(body.layer.window)
                if overlap is not None:
                    body.visible[_slices(overlap, body.layer.window)] *= (
                        1.0 - nearer.layer.coverage[_slices(overlap, nearer.layer.window)]
                    )
        return bodies

    def _areas(
        self,
        camera: CameraModel,
        pose: ViewPose,
        robots: Sequence[RobotState],
        bodies: list[_Body],
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
        return _merged(clipped)

    def _effects(
        self,
        bodies: list[_Body],
        robots: Sequence[RobotState],
        area: Window,
        camera: CameraModel,
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
                _paint(water.glow, self._wobbled(body, area, water, pose, gain), area, above=False)

        return apply

    @staticmethod
    def _wobbled(body: _Body, area: Window, water: Water, pose: ViewPose, gain: float) -> Layer:
        overlap = body.layer.window.clipped(area)
        if overlap is None or gain < 0.5:
            return body.layer
        inside = _slices(overlap, area)
        east = water.waves.slope_east[inside]
        north = water.waves.slope_north[inside]
        axes = pose.enu_from_optical
        below = body.layer.below.copy()
        here = _slices(overlap, body.layer.window)
        right = east * np.float32(axes[0, 0]) + north * np.float32(axes[1, 0])
        down = east * np.float32(axes[0, 1]) + north * np.float32(axes[1, 1])
        below[here] = wobble(np.ascontiguousarray(below[here]), right, down, gain)
        return Layer(body.layer.window, below, body.layer.above, body.layer.coverage)

    def _label(
        self,
        body: _Body,
        camera: CameraModel,
        pose: ViewPose,
        part: Window,
        contrasts: dict[str, float],
    ) -> RobotLabel | None:
        state = body.state
        if state is None or state.robot_id not in contrasts:
            return None
        pixels, _ = project_points(camera, pose, body.mesh.vertices)
        box = box_of_points(pixels, part)
        overlap = body.layer.window.clipped(part)
        if box is None or overlap is None:
            return None
        total = float(body.layer.coverage.sum())
        seen = float(body.visible[_slices(overlap, body.layer.window)].sum())
        if seen < 0.5:
            return None
        long_px, short_px = turned_size(pixels)
        middle, _ = project_points(camera, pose, np.array([[state.east, state.north, 0.0]]))
        return RobotLabel(
            state.robot_id, state.class_name, *box, long_px, short_px, state.depth,
            contrasts[state.robot_id], seen / total, (float(middle[0, 0]), float(middle[0, 1])),
        )  # fmt: skip


def _slices(inner: Window, outer: Window) -> tuple[slice, slice]:
    """Rows and columns of `inner` in an array that covers `outer`."""
    y, x = inner.y - outer.y, inner.x - outer.x
    return slice(y, y + inner.height), slice(x, x + inner.width)


def _paint(planes: list[F32], layer: Layer, area: Window, above: bool) -> None:
    """Composites one part of a layer over planes that cover `area`."""
    overlap = layer.window.clipped(area)
    if overlap is None:
        return
    source = (layer.above if above else layer.below)[_slices(overlap, layer.window)]
    target = _slices(overlap, area)
    for i, plane in enumerate(planes):
        plane[target] = plane[target] * (1.0 - source[..., 3]) + source[..., i]


def _contrasts(
    bodies: list[_Body], area: Window, clean: NDArray[np.uint8], dirty: NDArray[np.uint8]
) -> dict[str, float]:
    result = {}
    change = cv2.absdiff(clean, dirty).mean(axis=-1) / 255.0
    for body in bodies:
        overlap = body.layer.window.clipped(area)
        if body.state is None or overlap is None:
            continue
        weight = body.visible[_slices(overlap, body.layer.window)]
        total = float(weight.sum())
        value = float((change[_slices(overlap, area)] * weight).sum()) / total if total > 0 else 0.0
        result[body.state.robot_id] = value
    return result


def _merged(windows: list[Window]) -> list[Window]:
    """Unites overlapping windows until all are disjoint."""
    done: list[Window] = []
    for window in windows:
        merging = True
        while merging:
            merging = False
            for other in done:
                if window.clipped(other) is not None:
                    done.remove(other)
                    x, y = min(window.x, other.x), min(window.y, other.y)
                    right = max(window.x + window.width, other.x + other.width)
                    bottom = max(window.y + window.height, other.y + other.height)
                    window = Window(x, y, right - x, bottom - y)
                    merging = True
                    break
        done.append(window)
    return done
