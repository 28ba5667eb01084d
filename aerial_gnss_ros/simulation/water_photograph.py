# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A flight over photographed water: the photograph lies on the water's plane, robots float in it.

The photograph is taken as seen from straight above. It repeats itself, mirrored, and does not move:
what is in it (foam, glint, boats) stays where it is on the water.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.develop import Developer, as_levels, as_light
from aerial_gnss_ros.simulation.hexapod import RobotState
from aerial_gnss_ros.simulation.labels import RobotLabel
from aerial_gnss_ros.simulation.mesh import Mesh
from aerial_gnss_ros.simulation.over_photograph import LUMA, PhotographRenderer, matching_gain
from aerial_gnss_ros.simulation.planes import F32, U8, merge
from aerial_gnss_ros.simulation.renderer import noise_seed
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.shading import Shader
from aerial_gnss_ros.simulation.view import ViewPose, Window

LEAST_PX = 64
_GRAZING = 0.01  # sine of the angle to the water below which the horizon's haze hides it
_DARKEST = 2e-3  # light from below the surface of the darkest lakes
_STEP = 16  # px between the rays that match the exposure


@dataclass(frozen=True, eq=False)
class WaterPhotograph:
    """A photograph of water.

    Attributes:
        image: (height, width, 3) blue, green, red.
        width_m: that its width has on the water.

    Raises:
        ConfigError: it is smaller than `LEAST_PX` on a side, or `width_m` is out of its range.
    """

    image: U8
    width_m: float

    def __post_init__(self) -> None:
        height, width = self.image.shape[:2]
        if min(height, width) < LEAST_PX:
            raise ConfigError(
                f"the photograph of water has {width}x{height} px; {LEAST_PX}x{LEAST_PX} are "
                "needed at the least."
            )
        if not 1.0 <= self.width_m <= 10_000.0:
            raise ConfigError(f"--water-width must lie within 1 to 10000 m, not {self.width_m:g}.")


class WaterRenderer(PhotographRenderer):
    """Renders robots and other things over a photograph that lies on the water.

    Args:
        scene: light on what floats, waves that bend the view of what is under water; its water
            takes the photograph's colour. Its seed decides where on the photograph the flight is,
            and how that is turned.
        water: the photograph.
    """

    def __init__(self, scene: Scene, water: WaterPhotograph) -> None:
        super().__init__(coloured(scene, water.image))
        self._noise = Developer(replace(scene, blur_px=0.0, motion_px=(0.0, 0.0)))
        self._levels = [water.image]
        while min(self._levels[-1].shape[:2]) >= 8:
            self._levels.append(np.asarray(cv2.pyrDown(self._levels[-1]), np.uint8))
        self._metres_per_px = water.width_m / water.image.shape[1]
        rng = np.random.default_rng([scene.seed, 8])
        self._turn = float(rng.uniform(-np.pi, np.pi))
        self._origin = rng.uniform(0.0, water.image.shape[1::-1])

    def render(
        self,
        camera: CameraModel,
        pose: ViewPose,
        t_s: float,
        robots: Sequence[RobotState],
        props: Sequence[Mesh] = (),
        window: Window | None = None,
    ) -> tuple[U8, list[RobotLabel]]:
        """Render an image, as `Renderer.render` does."""
        part = Window(0, 0, camera.width, camera.height) if window is None else window
        self._shader.sea.set_time(t_s)
        sea = self._photographed(camera, pose, part)
        image, labels = self.draw_into(
            sea, camera, pose, t_s, robots, props, window=part, softness_px=self.scene.blur_px
        )
        return self._noise.finish(image, noise_seed(t_s, part)), labels

    def _photographed(self, camera: CameraModel, pose: ViewPose, part: Window) -> U8:
        """Return the photograph as the camera sees it on the water, under the rendered sky."""
        angle, rays = self._pixel_angle(camera), self._window_rays(camera, part)
        directions = self._directions(rays, pose.enu_from_optical.astype(np.float32))
        east, north, up = directions
        sky = up > -_GRAZING
        distance = pose.position[2] / np.maximum(-up, _GRAZING)
        # A pixel covers distance * angle across, and 1 / sine as much along the line of sight: the
        # photograph is averaged over their geometric mean.
        blurred = distance * angle / (np.sqrt(np.maximum(-up, _GRAZING)) * self._metres_per_px)
        image = self._sampled(
            pose.position[0] + east * distance,
            pose.position[1] + north * distance,
            np.log2(np.maximum(blurred, 1.0)),
        )
        if sky.any():
            coarse = np.ascontiguousarray(rays[::_STEP, ::_STEP])
            below = self._directions(coarse, pose.enu_from_optical.astype(np.float32))
            light = self._shader.shade(below, pose.position, angle * _STEP)
            whole = merge(self._shader.shade(directions, pose.position, angle))
            image[sky] = as_levels(whole * matching_gain(image, light))[sky]
        return image

    def _sampled(self, east: F32, north: F32, level: F32) -> U8:
        """Return the photograph's colours at places on the water, averaged over 2^level pixels."""
        c, s = np.cos(self._turn), np.sin(self._turn)
        u = (c * east + s * north) / self._metres_per_px + self._origin[0]
        v = (s * east - c * north) / self._metres_per_px + self._origin[1]
        height, width = self._levels[0].shape[:2]
        u, v = _mirrored(u, width), _mirrored(v, height)
        level = np.clip(level, 0.0, len(self._levels) - 1)
        low = int(level.min())
        result = self._looked_up(low, u, v).astype(np.float32)
        for k in range(low + 1, int(np.ceil(level.max())) + 1):
            share = np.clip(level - (k - 1), 0.0, 1.0)[..., None]
            result += share * (self._looked_up(k, u, v) - result)
        return np.asarray(np.round(result), np.uint8)

    def _looked_up(self, level: int, u: F32, v: F32) -> U8:
        """Return colours of one level; u, v in pixels of the photograph, first one from 0 to 1."""
        own, whole = self._levels[level].shape, self._levels[0].shape
        x = (u * (own[1] / whole[1]) - 0.5).astype(np.float32)
        y = (v * (own[0] / whole[0]) - 0.5).astype(np.float32)
        found = cv2.remap(
            self._levels[level], x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT
        )
        return np.asarray(found, np.uint8)


def coloured(scene: Scene, photograph: U8) -> Scene:
    """Return a scene whose water has a photograph's hue: foam on it is white then, not tinted.

    Args:
        scene: any.
        photograph: (height, width, 3).
    """
    azimuth, dip = np.meshgrid(np.linspace(-np.pi, np.pi, 24, endpoint=False), [0.7, 0.9, 1.2])
    ways = (np.cos(azimuth) * np.cos(dip), np.sin(azimuth) * np.cos(dip), -np.sin(dip))
    directions = [np.asarray(way, np.float32) for way in ways]
    shader = Shader(scene)
    shader.sea.set_time(0.0)
    sea = np.stack(shader.shade(directions, np.array([0.0, 0.0, 15.0]), 0.05), axis=-1)
    rendered = np.median(sea.reshape(-1, 3), axis=0)
    seen = np.median(as_light(photograph[::4, ::4]).reshape(-1, 3), axis=0)
    wanted = seen * (rendered @ LUMA) / max(float(seen @ LUMA), 1e-4)
    blue, green, red = np.maximum(np.array(scene.water_colour) + wanted - rendered, _DARKEST)
    return replace(scene, water_colour=(float(blue), float(green), float(red)))


def _mirrored(places: F32, size: int) -> F32:
    """Return places inside 0 to size; beyond, the axis goes back and forth."""
    folded = np.mod(places, 2.0 * size)
    return np.asarray(np.where(folded > size, 2.0 * size - folded, folded))
