# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The sky of a scene as a radiance map, looked up by direction."""

from __future__ import annotations

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.planes import F32, remap, split
from aerial_gnss_ros.simulation.scene import Scene

SIZE = 320
REACH = 1.06
"""The map spans the unit disc (the horizon is its rim) and a little more."""


class Sky:
    """Sky radiance by direction: gradient, glow around the sun, clouds.

    The upper half sphere is stored stereographically: direction (x, y, z) lies at
    (x, y) / (1 + z), which keeps its resolution at the horizon.
    """

    def __init__(self, scene: Scene) -> None:
        axis = np.linspace(-REACH, REACH, SIZE)
        px, py = np.meshgrid(axis, axis)
        square = np.minimum(px**2 + py**2, 1.0)
        z = (1.0 - square) / (1.0 + square)
        norm = np.maximum(np.hypot(px, py), 1e-9)
        flat = np.sqrt(1.0 - z**2) / norm
        x, y = px * flat, py * flat
        zenith, horizon = np.array(scene.sky_zenith), np.array(scene.sky_horizon)
        share = np.sqrt(z)[..., None]
        colour = horizon * (1.0 - share) + zenith * share
        cosine = x * scene.sun_direction[0] + y * scene.sun_direction[1]
        cosine = cosine + z * scene.sun_direction[2]
        near = np.clip(0.5 + 0.5 * cosine, 0.0, 1.0)
        glow = (0.35 * near**6 + 0.9 * near**60 + 2.5 * near**600) * scene.sun_light
        colour = colour * (1.0 + glow[..., None]) + (0.25 * glow * near**20)[..., None]
        colour = self._clouds(scene, colour, x, y, z, near)
        self._map = np.ascontiguousarray(colour, dtype=np.float32)
        # Mean over the upper half sphere weighted by the cosine: light on a level white sheet.
        weight = z * (2.0 / (1.0 + square)) ** 2 * (px**2 + py**2 < 1.0)
        self.irradiance: NDArray[np.float64] = (colour * weight[..., None]).sum(
            axis=(0, 1)
        ) / weight.sum()
        self.horizon: NDArray[np.float64] = np.array(
            [np.median(colour[..., i][(z < 0.08)]) for i in range(3)]
        )

    @staticmethod
    def _clouds(
        scene: Scene,
        colour: NDArray[np.float64],
        x: NDArray[np.float64],
        y: NDArray[np.float64],
        z: NDArray[np.float64],
        near: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        if scene.cloud_cover <= 0.0:
            return colour
        rng = np.random.default_rng([scene.seed, 2])
        n = 256
        k = np.fft.fftfreq(n)[:, None] ** 2 + np.fft.rfftfreq(n)[None, :] ** 2
        k[0, 0] = np.inf
        noise = scipy.fft.irfft2(scipy.fft.rfft2(rng.standard_normal((n, n))) * k**-0.95, s=(n, n))
        # A layer at constant height: position on it is the tangent of the angle from the zenith.
        u = (x / (z + 0.12) * 0.11 * n) % n
        v = (y / (z + 0.12) * 0.11 * n) % n
        padded = np.pad(noise, (0, 1), mode="wrap").astype(np.float32)
        field = remap(padded, u.astype(np.float32), v.astype(np.float32))
        limit = np.quantile(noise, 1.0 - scene.cloud_cover)
        soft = 0.35 * noise.std()
        density = np.clip((field - limit) / soft + 0.2, 0.0, 1.0)
        density = density * np.clip(z * 8.0, 0.0, 1.0) * 0.92
        lit = 0.45 + 0.4 * scene.sun_light + 0.5 * near**12 * scene.sun_light
        shade = 1.0 - 0.35 * np.clip((field - limit) / (2.5 * soft), 0.0, 1.0)
        cloud = (lit * shade)[..., None] * np.array([1.0, 0.98, 0.96])
        blended: NDArray[np.float64] = (
            colour * (1.0 - density[..., None]) + cloud * density[..., None]
        )
        return blended

    def look(self, x: F32, y: F32, z: F32) -> list[F32]:
        """Radiance (blue, green, red planes) towards unit directions with z >= 0."""
        scale = np.float32((SIZE - 1) / (2.0 * REACH))
        shrink = scale / (1.0 + z)
        centre = np.float32((SIZE - 1) / 2.0)
        return split(remap(self._map, x * shrink + centre, y * shrink + centre))
