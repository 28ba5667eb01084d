# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Colour of daylight of a given temperature, and its effect on an image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

NEUTRAL_K = 6500.0
"""Colour temperature assumed for an unchanged image, K."""

# XYZ to linear sRGB, IEC 61966-2-1.
_SRGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])


def chromaticity(kelvin: float) -> tuple[float, float]:
    """Return CIE 1931 x, y of a black body, 1667 to 25000 K.

    Source: B. Kim et al., Design of advanced color temperature control system for HDTV
    applications, J. Korean Phys. Soc. 41 (2002), cubic approximation of the Planckian locus.
    """
    t = 1000.0 / kelvin
    if kelvin <= 4000.0:
        x = -0.2661239 * t**3 - 0.2343589 * t**2 + 0.8776956 * t + 0.179910
    else:
        x = -3.0258469 * t**3 + 2.1070379 * t**2 + 0.2226347 * t + 0.240390
    if kelvin <= 2222.0:
        y = -1.1063814 * x**3 - 1.34811020 * x**2 + 2.18555832 * x - 0.20219683
    elif kelvin <= 4000.0:
        y = -0.9549476 * x**3 - 1.37418593 * x**2 + 2.09137015 * x - 0.16748867
    else:
        y = 3.0817580 * x**3 - 5.87338670 * x**2 + 3.75112997 * x - 0.37001483
    return x, y


def gains(kelvin: float) -> NDArray[np.float64]:
    """Return the factors of linear blue, green and red under light of this temperature.

    Relative to NEUTRAL_K, and so that the luminance of grey stays (Rec. 709 weights).
    """
    light = _linear_rgb(kelvin) / _linear_rgb(NEUTRAL_K)
    light /= light @ np.array([0.2126, 0.7152, 0.0722])
    return light[::-1].copy()


def table(kelvin: float) -> NDArray[np.uint8]:
    """Return (256, 3), blue, green, red: what each 8 bit value becomes."""
    linear = decode_srgb(np.arange(256) / 255.0)[:, None] * gains(kelvin)
    return np.asarray(np.rint(255.0 * encode_srgb(linear)), dtype=np.uint8)


def decode_srgb(value: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return linear light of sRGB values, both 0 to 1 (IEC 61966-2-1)."""
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def encode_srgb(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return sRGB values 0 to 1 of linear light; more light than 1 is 1."""
    light = np.clip(linear, 0.0, 1.0)
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1.0 / 2.4) - 0.055)


def _linear_rgb(kelvin: float) -> NDArray[np.float64]:
    x, y = chromaticity(kelvin)
    return np.asarray(_SRGB @ np.array([x / y, 1.0, (1.0 - x - y) / y]))
