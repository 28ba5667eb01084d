# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Moving water: tileable slope fields of an ocean spectrum, sampled at points of the surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.planes import F32, remap, resize, shrink
from aerial_gnss_ros.simulation.scene import Scene

GRAVITY = 9.81
CAPILLARY = 7.4e-5
"""Surface tension over density, m³/s²: makes ripples shorter than 2 cm run faster."""
TILE = 256
LONGEST = (43.0, 8.3, 1.61, 0.31)
"""Longest wavelength of each band in metres; it ends where the next begins, the last at 6 cm."""
SHORTEST = 0.06
TILE_LENGTHS = tuple(8.0 * length for length in LONGEST)
# Tiles are turned against each other so that their repetitions never line up.
TURNS = (0.0, 0.61, 1.37, 2.21)
PATCH_LENGTH = 180.0
"""m after which the water's colour repeats."""
CUTOFF = 0.017
"""Wavelength in metres below which the wind sea has no energy (viscosity)."""


def slope_variance(wind_speed: float) -> float:
    """Mean square slope of a wind sea (Cox and Munk 1954), dimensionless."""
    return 0.003 + 0.00512 * wind_speed


@dataclass(frozen=True)
class SurfaceSample:
    """Waves at sampled points: slopes dz/dx, dz/dy, variance of the unresolved slope, foam 0..1."""

    slope_east: F32
    slope_north: F32
    variance: F32
    foam: F32 | None


class Sea:
    """The waves of one scene.

    A band holds the waves between two lengths in a periodic tile; waves that a pixel cannot resolve
    are faded out and returned as variance (roughness), so distant water does not alias.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        rng = np.random.default_rng([scene.seed, 1])
        self._bands = [_Band(scene, i, rng) for i in range(len(LONGEST))]
        self.residual_variance = _saturation(scene.wind_speed) * np.log(SHORTEST / CUTOFF) * 0.5
        self._patches = _noise_tile(rng, exponent=2.2)
        self._foam_detail = _noise_tile(rng, exponent=1.0)
        self._time: float | None = None
        self._tiles: list[F32 | None] = []

    def set_time(self, t_s: float) -> None:
        """Moves the waves to time `t_s` (seconds); tiles are made when first sampled."""
        if self._time != t_s:
            self._time = t_s
            self._tiles = [None] * len(self._bands)

    def sample(
        self, east: F32, north: F32, origin: NDArray[np.float64], pixel: F32
    ) -> SurfaceSample:
        """Waves at points of the surface.

        Args:
            east: (h, w) metres from `origin`.
            north: (h, w) metres from `origin`; neighbours in a row lie a pixel apart.
            origin: (2,) metres, ENU.
            pixel: (h, w) metres of water that one pixel spans.
        """
        variance = np.full(east.shape, self.residual_variance, dtype=np.float32)
        slope_e = np.zeros_like(east)
        slope_n = np.zeros_like(east)
        finest, coarsest = float(pixel.min()), float(pixel.max())
        foam: F32 | None = None
        for i, band in enumerate(self._bands):
            if band.variance == 0.0:
                continue
            if finest > band.longest / 3.0:
                variance += np.float32(band.variance)
                continue
            field = self._sample_tile(i, east, north, origin, coarsest)
            weight = _fade(pixel, band.shortest / 3.0, band.longest / 3.0)
            slope_e += field[..., 0] * weight
            slope_n += field[..., 1] * weight
            variance += np.float32(band.variance) * (1.0 - weight * weight)
            if i == 1 and band.foamy:
                foam = self._foam(field[..., 2], east, north, origin)
        return SurfaceSample(slope_e, slope_n, variance, foam)

    def patches(self, east: F32, north: F32, origin: NDArray[np.float64]) -> F32:
        """Slow relative variation of the water's colour at points, mean 0, standard deviation 1."""
        stride = _stride(PATCH_LENGTH / 20.0, float(np.abs(np.diff(east[::8])).max(initial=0.0)))
        return _lookup(self._patches, east, north, origin, PATCH_LENGTH, 0.3, stride)

    def lumps(self, east: F32, north: F32, origin: NDArray[np.float64]) -> F32:
        """Fine noise that breaks up foam, at points, mean 0, standard deviation 1."""
        return _lookup(self._foam_detail, east, north, origin, 5.3, 0.9)

    def _sample_tile(
        self, i: int, east: F32, north: F32, origin: NDArray[np.float64], coarsest: float
    ) -> F32:
        tile = self._tiles[i]
        if tile is None:
            if self._time is None:
                self.set_time(0.0)
            tile = self._bands[i].tile(self._time or 0.0)
            self._tiles[i] = tile
        stride = _stride(self._bands[i].shortest, coarsest)
        return _lookup(tile, east, north, origin, TILE_LENGTHS[i], TURNS[i], stride)

    def _foam(self, crest: F32, east: F32, north: F32, origin: NDArray[np.float64]) -> F32:
        detail = self.lumps(east, north, origin)
        # Foam is broken up: where it is thin, only the peaks of the noise remain.
        foam: F32 = crest * 1.6 + (detail * 0.45 - 0.75) * np.minimum(crest * 8.0, 1.0)
        np.clip(foam, 0.0, 0.9, out=foam)
        return foam


def _fade(pixel: F32, full: float, none: float) -> F32:
    """1 where a pixel is smaller than `full` metres, 0 where larger than `none`, smooth in log."""
    x = np.log(pixel)
    x -= np.float32(np.log(none))
    x *= np.float32(1.0 / (np.log(full) - np.log(none)))
    np.clip(x, 0.0, 1.0, out=x)
    return x * x * (3.0 - 2.0 * x)


def _stride(shortest: float, pixel: float) -> int:
    """Columns from one sample of a field to the next where its waves are much longer than that."""
    return 4 if 4.0 * pixel < shortest / 12.0 else 1


def _lookup(
    tile: F32,
    east: F32,
    north: F32,
    origin: NDArray[np.float64],
    length: float,
    turn: float,
    stride: int = 1,
) -> F32:
    """Samples a periodic tile (padded by one row and column) spanning `length` metres.

    With a stride, one column in so many is sampled and those between are interpolated, which is
    much faster than sampling.
    """
    full = (east.shape[1], east.shape[0])
    if stride > 1 and full[0] >= 8 * stride:
        size = (full[0] // stride, full[1])
        east, north = shrink(east, size), shrink(north, size)
    n = tile.shape[0] - 1
    c, s = np.cos(turn), np.sin(turn)
    u0 = (c * origin[0] + s * origin[1]) / length % 1.0
    v0 = (-s * origin[0] + c * origin[1]) / length % 1.0
    u = east * np.float32(c / length) + north * np.float32(s / length) + np.float32(u0)
    v = east * np.float32(-s / length) + north * np.float32(c / length) + np.float32(v0)
    for x in (u, v):
        np.subtract(x, np.floor(x), out=x)
        np.multiply(x, np.float32(n), out=x)
    field = remap(tile, u, v)
    return field if east.shape[1] == full[0] else resize(field, full)


def _pad(field: NDArray[np.generic]) -> F32:
    """Repeats the first row and column at the end, so that bilinear sampling wraps."""
    width = [(0, 1), (0, 1)] + [(0, 0)] * (field.ndim - 2)
    return np.ascontiguousarray(np.pad(field, width, mode="wrap"), dtype=np.float32)


def _noise_tile(rng: np.random.Generator, exponent: float) -> F32:
    """Periodic fractal noise (TILE+1, TILE+1), mean 0, standard deviation 1."""
    k = np.fft.fftfreq(TILE)[:, None] ** 2 + np.fft.rfftfreq(TILE)[None, :] ** 2
    k[0, 0] = np.inf
    white = scipy.fft.rfft2(rng.standard_normal((TILE, TILE)))
    field = scipy.fft.irfft2(white * k ** (-exponent / 2.0), s=(TILE, TILE))
    return _pad(field / field.std())


def _saturation(wind_speed: float) -> float:
    """Slope variance per e-fold of wavenumber of the wind sea, so that the sum is Cox-Munk's."""
    if wind_speed <= 0.0:  # glassy water, for tests
        return 0.0
    return slope_variance(wind_speed) / float(np.log(_peak_length(wind_speed) / CUTOFF))


def _peak_length(wind_speed: float) -> float:
    """Wavelength in metres of the Pierson-Moskowitz peak (omega_p = 0.877 g / U)."""
    return max(2.0 * np.pi * wind_speed**2 / (0.877**2 * GRAVITY), 0.5)


class _Band:
    """Waves of one octave range in a periodic tile of `TILE` x `TILE` samples."""

    def __init__(self, scene: Scene, i: int, rng: np.random.Generator) -> None:
        self.longest = LONGEST[i]
        self.shortest = LONGEST[i + 1] if i + 1 < len(LONGEST) else SHORTEST
        length = TILE_LENGTHS[i]
        k1 = 2.0 * np.pi * scipy.fft.fftfreq(TILE, length / TILE)
        kx, ky = np.meshgrid(k1, k1)
        k = np.hypot(kx, ky)
        k[0, 0] = 1.0
        density = self._density(scene, k, np.arctan2(ky, kx) + TURNS[i], first=i == 0)
        density[0, 0] = 0.0
        step = 2.0 * np.pi / length
        noise = rng.standard_normal((2, TILE, TILE))
        amplitude = np.sqrt(density) * step / 2.0
        self._h0 = (noise[0] + 1j * noise[1]) * amplitude * TILE**2
        self._kx, self._ky, self._k = kx, ky, k
        self._omega = np.sqrt(GRAVITY * k + CAPILLARY * k**3)
        self._turn = TURNS[i]
        # h0 exp(i w t) + its conjugate partner: variance is the sum of the density.
        self.variance = float((density * k**2).sum() * step**2)
        self.foamy = i == 1 and scene.whitecaps > 0.0 and scene.wind_speed > 4.0
        # Coverage after Monahan and O'Muircheartaigh (1980), W = 3.84e-6 U^3.41, doubled because
        # visible foam includes the bubbles behind a crest.
        coverage = min(2.0 * scene.whitecaps * 3.84e-6 * scene.wind_speed**3.41, 0.08)
        self._coverage = coverage

    def _density(
        self, scene: Scene, k: NDArray[np.float64], yaw: NDArray[np.float64], first: bool
    ) -> NDArray[np.float64]:
        """Elevation variance per unit area of wavenumber, m⁴: Pierson-Moskowitz, k⁻³ tail."""
        peak = 2.0 * np.pi / _peak_length(scene.wind_speed)
        omni = _saturation(scene.wind_speed) * k**-3.0 * np.exp(-1.25 * (peak / k) ** 2)
        spread = np.clip(8.0 * (k / peak) ** -0.5, 1.0, 8.0)
        shape = np.abs(np.cos((yaw - scene.wind_yaw) / 2.0)) ** (2.0 * spread)
        # Integral of cos^2s(x/2) over a turn is about 2 sqrt(pi / s) for the values met here.
        density = omni / k * shape / (2.0 * np.sqrt(np.pi / (spread + 0.25)))
        inside = (k >= 2.0 * np.pi / self.longest) & (k < 2.0 * np.pi / self.shortest)
        density = np.where(inside, density, 0.0)
        if first and scene.swell_slope > 0.0:
            ks = 2.0 * np.pi / scene.swell_length
            away = (np.log(k / ks) / 0.25) ** 2 + (
                np.sin((yaw - scene.swell_yaw) / 2.0) / 0.14
            ) ** 2
            swell = np.exp(-0.5 * away) / k**2
            step = np.abs(k[0, 1]) ** 2
            total = (swell * k**2).sum() * step
            density = density + swell * (scene.swell_slope**2 / max(total, 1e-12))
        return density

    def tile(self, t_s: float) -> F32:
        """Slopes (and foam where this band carries it) at time t, (TILE+1, TILE+1, 2 or 3)."""
        h = self._h0 * np.exp(-1j * self._omega * t_s)
        mirrored = np.conj(np.roll(h[::-1, ::-1], (1, 1), axis=(0, 1)))
        h = h + mirrored
        # One transform for two real fields: i kx h has a real inverse, and so has i ky h.
        both = scipy.fft.ifft2(1j * self._kx * h - self._ky * h)
        c, s = np.cos(self._turn), np.sin(self._turn)
        east = c * both.real - s * both.imag
        north = s * both.real + c * both.imag
        layers = [east, north]
        if self.foamy:
            layers.append(self._crests(h))
        return _pad(np.stack(layers, axis=-1))

    def _crests(self, h: NDArray[np.complex128]) -> NDArray[np.float64]:
        """Where wave crests converge enough to break, 0 to about 1, over the given share."""
        squeeze = scipy.fft.ifft2(self._k * h).real
        limit, full = np.quantile(squeeze, [1.0 - self._coverage, 1.0 - 0.15 * self._coverage])
        foam: NDArray[np.float64] = np.clip((squeeze - limit) / max(full - limit, 1e-9), 0.0, 1.0)
        return foam
