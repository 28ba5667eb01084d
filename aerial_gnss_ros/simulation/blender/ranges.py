# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ranges of random draws: `train`, and `unseen`, which shares no range with it.

View geometry (height, tilt, lens, size in the image) is the same in both: the question is whether a
detector recognises robots and seas that it never saw, not whether it can see smaller ones.
"""

from __future__ import annotations

from dataclasses import dataclass

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.scene import Colour

Span = tuple[float, float]


@dataclass(frozen=True)
class Paint:
    """Colours of a robot: linear reflectance blue, green, red; how metallic the hull is."""

    hull: Colour
    deck: Colour
    mark: Colour
    flipper: Colour
    metallic: float = 0.0


PAINTS: dict[str, Paint] = {
    "yellow": Paint((0.02, 0.45, 0.75), (0.03, 0.03, 0.03), (0.6, 0.6, 0.6), (0.02, 0.02, 0.02)),
    "white": Paint((0.70, 0.72, 0.72), (0.30, 0.30, 0.30), (0.02, 0.02, 0.4), (0.03, 0.03, 0.03)),
    "black": Paint((0.02, 0.02, 0.02), (0.10, 0.10, 0.10), (0.02, 0.5, 0.7), (0.02, 0.02, 0.02)),
    "blue": Paint((0.55, 0.16, 0.04), (0.06, 0.05, 0.05), (0.7, 0.7, 0.7), (0.03, 0.03, 0.03)),
    "lime": Paint((0.05, 0.60, 0.30), (0.05, 0.05, 0.05), (0.5, 0.5, 0.5), (0.04, 0.35, 0.45)),
    "grey": Paint((0.25, 0.25, 0.24), (0.55, 0.55, 0.55), (0.03, 0.3, 0.7), (0.02, 0.02, 0.02)),
    "gold": Paint((0.10, 0.40, 0.62), (0.30, 0.31, 0.32), (0.02,) * 3, (0.02, 0.03, 0.03), 0.7),
    "orange": Paint((0.02, 0.18, 0.75), (0.04, 0.04, 0.04), (0.7, 0.7, 0.7), (0.02, 0.02, 0.02)),
    "silver": Paint((0.60, 0.60, 0.58), (0.05, 0.05, 0.05), (0.02, 0.2, 0.7), (0.02,) * 3, 0.8),
    "red": Paint((0.03, 0.03, 0.50), (0.50, 0.50, 0.50), (0.03, 0.03, 0.03), (0.04, 0.04, 0.05)),
    "turquoise": Paint((0.45, 0.45, 0.03), (0.05, 0.05, 0.05), (0.6, 0.6, 0.6), (0.3, 0.3, 0.03)),
    "pink": Paint((0.35, 0.10, 0.70), (0.60, 0.60, 0.60), (0.03, 0.03, 0.03), (0.05, 0.04, 0.05)),
}  # fmt: skip


@dataclass(frozen=True)
class Ranges:
    """One named set of ranges.

    Attributes:
        paints: keys of `PAINTS`.
        gaits: keys of `hexapod.GAITS`.
        leans_rad: standard deviation of the hull's roll and pitch.
        waters: keys of `scene.WATERS`.
        spectra: of the ocean modifier.
        wind_mps: spans of the wind, one is taken.
        sun_elevation_deg: spans, one is taken.
        overcast: probability of a sky without a sun.
        clouds: probability of broken clouds where the sun shines.
        props: "floating" (`simulation.props`) or "harbour" (`blender.props`).
    """

    paints: tuple[str, ...]
    gaits: tuple[str, ...]
    leans_rad: float
    waters: tuple[str, ...]
    spectra: tuple[str, ...]
    wind_mps: tuple[Span, ...]
    sun_elevation_deg: tuple[Span, ...]
    overcast: float
    clouds: float
    props: str


RANGES: dict[str, Ranges] = {
    "train": Ranges(
        paints=("yellow", "white", "black", "blue", "lime", "grey", "gold"),
        gaits=("tripod", "hover", "glide"),
        leans_rad=0.08,
        waters=("ocean", "coastal", "green", "harbour", "lake"),
        spectra=("PHILLIPS", "PIERSON_MOSKOWITZ"),
        wind_mps=((0.8, 4.0), (6.0, 10.0)),
        sun_elevation_deg=((18.0, 48.0), (62.0, 80.0)),
        overcast=0.3,
        clouds=0.0,
        props="floating",
    ),
    "unseen": Ranges(
        paints=("orange", "silver", "red", "turquoise", "pink"),
        gaits=("turn", "brake", "walk"),
        leans_rad=0.16,
        waters=("tropical", "lagoon", "silty"),
        spectra=("JONSWAP", "TEXEL_MARSEN_ARSLOE"),
        wind_mps=((4.0, 6.0), (10.0, 11.5)),
        sun_elevation_deg=((10.0, 18.0), (48.0, 62.0)),
        overcast=0.0,
        clouds=0.5,
        props="harbour",
    ),
}


def ranges_named(name: str) -> Ranges:
    """Return the ranges of that name.

    Raises:
        ConfigError: there are no ranges of that name.
    """
    if name not in RANGES:
        raise ConfigError(f"there are no ranges {name!r}; choose one of {', '.join(RANGES)}.")
    return RANGES[name]
