# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The look of a rendered scene: sun, sky, waves, water, camera; fixed or random."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

Colour = tuple[float, float, float]
"""Blue, green, red, linear light (not gamma coded); 1 is a white sheet in full daylight."""


@dataclass(frozen=True)
class Scene:
    """All parameters of a scene's look, without the camera's pose and the robots.

    Angles are radians. Directions are yaw in ENU (0 = east, counter-clockwise). Colours are
    `Colour` (blue, green, red; linear).

    Attributes:
        seed: Seeds the waves, clouds, water patches and sensor noise.
        sun_yaw: Direction in which the sun stands.
        sun_elevation: Of the sun above the horizon.
        sun_light: Share of daylight that comes directly from the sun (0 overcast, about 0.8 clear).
        sky_zenith, sky_horizon: Sky radiance.
        cloud_cover: 0 (none) to 1 (closed).
        wind_speed: m/s at 10 m; makes the wind sea (Pierson-Moskowitz, Cox-Munk slopes).
        wind_yaw: Direction towards which the wind blows.
        swell_slope: RMS slope of an additional swell; swell_length: its wavelength in m; swell_yaw.
        water_colour: Radiance of deep water from below, in full daylight.
        attenuation: Diffuse attenuation of the water, 1/m per colour (turbidity).
        patchiness: Relative variation of the water's colour over tens of metres.
        whitecaps: 0 none, 1 as expected for the wind.
        visibility_m: Distance at which haze leaves 2 % of the contrast.
        exposure: Multiplies the automatic exposure.
        white_balance: Gain per colour.
        saturation: 0 grey, 1 natural.
        blur_px: Softness of the lens, standard deviation of a Gaussian; 0 none.
        vignette: Relative darkening of the image corner.
        motion_px: Motion blur right and down, px.
        noise: Standard deviation of the sensor's noise in grey levels.
    """

    seed: int = 0
    sun_yaw: float = 2.1
    sun_elevation: float = 0.85
    sun_light: float = 0.75
    sky_zenith: Colour = (0.42, 0.24, 0.13)
    sky_horizon: Colour = (0.72, 0.64, 0.55)
    cloud_cover: float = 0.25
    wind_speed: float = 5.0
    wind_yaw: float = 0.4
    swell_slope: float = 0.02
    swell_length: float = 25.0
    swell_yaw: float = 0.9
    water_colour: Colour = (0.105, 0.075, 0.018)
    attenuation: Colour = (0.12, 0.13, 0.42)
    patchiness: float = 0.15
    whitecaps: float = 1.0
    visibility_m: float = 12_000.0
    exposure: float = 1.0
    white_balance: Colour = (1.0, 1.0, 1.0)
    saturation: float = 1.0
    blur_px: float = 0.45
    vignette: float = 0.08
    motion_px: tuple[float, float] = (0.0, 0.0)
    noise: float = 1.5

    @property
    def sun_direction(self) -> np.ndarray:
        """Unit vector (3,) towards the sun, ENU."""
        c = np.cos(self.sun_elevation)
        return np.array(
            [c * np.cos(self.sun_yaw), c * np.sin(self.sun_yaw), np.sin(self.sun_elevation)]
        )


# Deep water seen from above, from open ocean to harbour: (radiance BGR, attenuation BGR in 1/m).
# Radiances follow the look of Jerlov's water types; attenuations lie near his table.
WATERS: dict[str, tuple[Colour, Colour]] = {
    "ocean": ((0.100, 0.036, 0.006), (0.05, 0.08, 0.36)),
    "tropical": ((0.160, 0.130, 0.022), (0.07, 0.09, 0.38)),
    "lagoon": ((0.230, 0.230, 0.080), (0.09, 0.10, 0.40)),
    "coastal": ((0.075, 0.070, 0.020), (0.18, 0.16, 0.46)),
    "green": ((0.040, 0.070, 0.025), (0.40, 0.25, 0.55)),
    "harbour": ((0.030, 0.040, 0.022), (0.80, 0.55, 0.70)),
    "silty": ((0.070, 0.110, 0.095), (1.60, 1.00, 0.90)),
    "lake": ((0.022, 0.024, 0.014), (1.10, 0.70, 0.70)),
}


def demo_scene(seed: int = 0) -> Scene:
    """The default scene for demonstrations: a bright afternoon over coastal tropical water."""
    return Scene(seed=seed)


def _mix(a: Colour, b: Colour, share: float, gain: float = 1.0) -> Colour:
    """`gain` times the colour that lies `share` of the way from a to b."""
    b_, g, r = (gain * ((1.0 - share) * p + share * q) for p, q in zip(a, b, strict=True))
    return b_, g, r


def random_scene(rng: np.random.Generator) -> Scene:
    """Draws a scene with wide variation, for training and demanding tests."""
    names = sorted(WATERS)
    a, b = (WATERS[names[i]] for i in rng.integers(len(names), size=2))
    share = float(rng.uniform(0.0, 0.5))
    water = _mix(a[0], b[0], share, gain=float(rng.lognormal(0.0, 0.25)))
    attenuation = _mix(a[1], b[1], share)
    overcast = rng.random() < 0.25
    cover = rng.uniform(0.8, 1.0) if overcast else rng.uniform(0.0, 0.6)
    sun_light = rng.uniform(0.0, 0.15) if overcast else rng.uniform(0.5, 0.85)
    elevation = np.radians(rng.uniform(12.0, 82.0))
    # A low sun is warm, and an overcast sky is grey.
    warm = float(np.clip(1.0 - elevation / np.radians(35.0), 0.0, 1.0))
    grey = rng.uniform(0.30, 0.55)
    blue = (rng.uniform(0.35, 0.6), rng.uniform(0.2, 0.33), rng.uniform(0.09, 0.2))
    grey *= 0.85
    zenith: Colour = (grey, grey, grey) if overcast else blue
    bright = rng.uniform(0.5, 0.95)
    horizon = (
        bright * (1.0 - 0.25 * warm),
        bright * (0.92 - 0.08 * warm),
        bright * (0.80 + 0.12 * warm if not overcast else 0.94),
    )
    cast = rng.normal(0.0, 0.05, size=2)
    wind = float(min(rng.gamma(2.2, 2.0) + 0.6, 12.0))
    return replace(
        Scene(),
        seed=int(rng.integers(2**31)),
        sun_yaw=float(rng.uniform(-np.pi, np.pi)),
        sun_elevation=float(elevation),
        sun_light=float(sun_light),
        sky_zenith=zenith,
        sky_horizon=horizon,
        cloud_cover=float(cover),
        wind_speed=wind,
        wind_yaw=float(rng.uniform(-np.pi, np.pi)),
        swell_slope=float(rng.uniform(0.0, 0.05)),
        swell_length=float(rng.uniform(12.0, 70.0)),
        swell_yaw=float(rng.uniform(-np.pi, np.pi)),
        water_colour=water,
        attenuation=attenuation,
        patchiness=float(rng.uniform(0.0, 0.45)),
        whitecaps=float(rng.choice([0.0, 1.0, 2.0], p=[0.25, 0.55, 0.2])),
        visibility_m=float(np.exp(rng.uniform(np.log(1_500.0), np.log(40_000.0)))),
        exposure=float(np.exp(rng.normal(0.0, 0.25))),
        white_balance=(float(1 + cast[0]), 1.0, float(1 + cast[1])),
        saturation=float(rng.uniform(0.6, 1.25)),
        blur_px=float(rng.uniform(0.0, 0.9)),
        vignette=float(rng.uniform(0.0, 0.3)),
        noise=float(rng.uniform(0.2, 5.0)),
    )


def with_wind(rng: np.random.Generator, scene: Scene, span: tuple[float, float] | None) -> Scene:
    """Return the scene with a wind drawn uniformly from a span, m/s; unchanged without one."""
    if span is None:
        return scene
    return replace(scene, wind_speed=float(rng.uniform(*span)))
