# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Light of sea and sky that reaches the camera along given rays (linear radiance planes)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.planes import F32
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.sea import Sea, SurfaceSample
from aerial_gnss_ros.simulation.sky import Sky


@dataclass
class Water:
    """The water at every pixel of a block, which robots may change before it is lit.

    Attributes:
        east, north: (h, w) m from `origin`.
        origin: (2,) m ENU.
        waves: Slopes, roughness and foam, changed in place.
        glow: Blue, green, red planes of the radiance from within the water, changed in place.
        sea: The sea model.
    """

    east: F32
    north: F32
    origin: NDArray[np.float64]
    waves: SurfaceSample
    glow: list[F32]
    sea: Sea


Effect = Callable[[Water], None]


class Shader:
    """Sea and sky of one scene, lit."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.sea = Sea(scene)
        self.sky = Sky(scene)
        sun = scene.sun_direction
        self._sun = sun.astype(np.float32)
        # A level white sheet sends back 1 in full daylight: sun and sky share it.
        self.sun_colour = _sun_colour(scene)
        self.sun_irradiance = self.sun_colour * scene.sun_light * float(sun[2]) ** 0.5
        self.daylight = self.sun_irradiance + self.sky.irradiance

    def shade(
        self,
        directions: list[F32],
        camera: NDArray[np.float64],
        pixel_angle: float,
        effects: Effect | None = None,
    ) -> list[F32]:
        """Radiance along rays.

        Args:
            directions: Unit ray directions in ENU: east, north, up planes (h, w).
            camera: (3,) camera position, m ENU, z above the mean water surface.
            pixel_angle: Angle that one pixel spans, rad (sets what waves can be resolved).
            effects: Changes the water before it is lit.

        Returns:
            Blue, green and red planes (h, w), linear.
        """
        up = directions[2]
        edge = np.float32(pixel_angle)
        lowest, highest = float(up.min()), float(up.max())
        if lowest > edge:
            return self.sky.look(*directions)
        colour = self._water(directions, camera, pixel_angle, effects)
        if highest > -edge:
            share = np.clip(0.5 - up / edge, 0.0, 1.0)
            above = self.sky.look(directions[0], directions[1], np.maximum(up, 0.0))
            colour = [c * share + a * (1.0 - share) for c, a in zip(colour, above, strict=True)]
        return colour

    def _water(
        self,
        directions: list[F32],
        camera: NDArray[np.float64],
        pixel_angle: float,
        effects: Effect | None,
    ) -> list[F32]:
        scene = self.scene
        dx, dy, up = directions
        mu = np.maximum(-up, np.float32(1e-4))
        distance = np.float32(camera[2]) / mu
        east, north = dx * distance, dy * distance
        # A pixel spans more water along the view than across it: between, nearer the larger.
        pixel = distance * np.float32(pixel_angle) * mu ** np.float32(-0.7)
        waves = self.sea.sample(east, north, camera[:2], pixel)
        patches = self.sea.patches(east, north, camera[:2])
        patches *= np.float32(scene.patchiness)
        light = np.exp(patches)
        glow = [
            light * np.float32(c * d)
            for c, d in zip(scene.water_colour, self.daylight, strict=True)
        ]
        water = Water(east, north, camera[:2], waves, glow, self.sea)
        if effects is not None:
            effects(water)
        colour = self._reflect(dx, dy, mu, water)
        if scene.visibility_m < 1e6:
            keep = np.exp(distance * np.float32(-3.9 / scene.visibility_m))
            for i, haze in enumerate(self.sky.horizon.astype(np.float32)):
                colour[i] -= haze
                colour[i] *= keep
                colour[i] += haze
        return colour

    def _reflect(self, dx: F32, dy: F32, mu: F32, water: Water) -> list[F32]:
        waves = water.waves
        sx, sy = waves.slope_east, waves.slope_north
        rough = np.sqrt(waves.variance)
        # Facet normal (-sx, -sy, 1) / length; cosine to the view.
        nz = 1.0 / np.sqrt(1.0 + sx * sx + sy * sy)
        cosine = (sx * dx + sy * dy + mu) * nz
        # Facets turned away are hidden behind nearer ones, and unresolved roughness tilts the
        # visible ones towards the viewer at grazing angles.
        cosine = np.maximum(cosine, 0.02)
        seen = np.minimum(np.sqrt(cosine * cosine + 0.5 * waves.variance), 1.0)
        miss = 1.0 - seen
        square = miss * miss
        fresnel = square * square * miss
        fresnel *= np.float32(0.98)
        fresnel += np.float32(0.02)
        twice = 2.0 * cosine * nz
        rx, ry = dx - twice * sx, dy - twice * sy
        rz = np.abs(twice - mu)
        rz += 0.35 * rough * (1.0 - mu)
        scale = 1.0 / np.sqrt(rx * rx + ry * ry + rz * rz)
        sky = self.sky.look(rx * scale, ry * scale, rz * scale)
        glint = self._glint(dx, dy, mu, sx, sy, waves.variance, fresnel)
        colour: list[F32] = []
        passed = 1.0 - fresnel
        # Light that entered facets tilted towards the sun makes wave fronts glow a little.
        tilt = 1.0 - 0.6 * (sx * self._sun[0] + sy * self._sun[1])
        passed *= np.clip(tilt, 0.5, 1.6)
        for i in range(3):
            plane = sky[i] * fresnel
            plane += water.glow[i] * passed
            if glint is not None:
                plane += glint * np.float32(self.sun_colour[i])
            if waves.foam is not None:
                white = np.float32(0.75 * self.daylight[i])
                plane += (white - plane) * waves.foam
            colour.append(plane)
        return colour

    def _glint(
        self, dx: F32, dy: F32, mu: F32, sx: F32, sy: F32, variance: F32, fresnel: F32
    ) -> F32 | None:
        """Sun reflected by facets whose slope is right (Cox and Munk's geometry)."""
        if self.scene.sun_light < 0.05:
            return None
        down = 1.0 / (mu + self._sun[2])
        zx, zy = (dx - self._sun[0]) * down, (dy - self._sun[1]) * down
        ex, ey = sx - zx, sy - zy
        # The sun's disc and the lens's stray light widen the smallest facets' spread.
        spread = 0.5 * variance + np.float32(0.0008)
        power = (ex * ex + ey * ey) / (-2.0 * spread)
        np.maximum(power, -60.0, out=power)
        if float(power.max()) < -14.0:
            return None
        glint: F32 = np.exp(power)
        steep = 1.0 + zx * zx + zy * zy
        glint *= fresnel * steep * steep / (spread * mu)
        glint *= np.float32(self.scene.sun_light * 0.15)
        np.minimum(glint, 12.0, out=glint)
        return glint


def _sun_colour(scene: Scene) -> NDArray[np.float64]:
    """Colour of direct sunlight: white when high, warm when low."""
    warm = float(np.clip(1.0 - scene.sun_elevation / np.radians(40.0), 0.0, 1.0))
    return np.array([1.0 - 0.55 * warm, 1.0 - 0.25 * warm, 1.0])
