# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The waves have the statistics and the speed of the spectrum that they come from."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.sea import Sea, slope_variance


def _points(span: float, count: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Points all over a square, in rows too short for the interpolation between neighbours."""
    axis = np.linspace(0.0, span, count, dtype=np.float32)
    east, north = np.meshgrid(axis, axis)
    return east.reshape(-1, 16), north.reshape(-1, 16)


@pytest.mark.parametrize("wind", [3.0, 6.0, 10.0])
def test_slopes_have_the_variance_of_cox_and_munk(wind: float) -> None:
    """Resolved and unresolved slopes add up to the measured law, fine or coarse."""
    sea = Sea(Scene(seed=4, wind_speed=wind, swell_slope=0.0))
    sea.set_time(12.0)
    east, north = _points(300.0)
    for pixel in (0.005, 0.2, 1.0):
        waves = sea.sample(east, north, np.zeros(2), np.full_like(east, pixel))
        resolved = float((waves.slope_east**2 + waves.slope_north**2).mean())
        total = resolved + float(waves.variance.mean())
        # The peak's roll-off and waves longer than the first tile are missing from the sum.
        assert 0.7 * slope_variance(wind) < total < 1.15 * slope_variance(wind)
    assert resolved < 0.4 * total  # a pixel of a metre hides most slopes


def test_a_swell_runs_at_the_speed_of_deep_water() -> None:
    """A 40 m swell moves with sqrt(g L / 2 pi) = 7.9 m/s along its direction."""
    scene = Scene(seed=1, wind_speed=0.0, swell_slope=0.05, swell_length=40.0, swell_yaw=0.0)
    sea = Sea(scene)
    x = np.arange(0.0, 330.0, 0.5, dtype=np.float32)
    east, north = np.meshgrid(x, np.zeros(1, np.float32))
    profiles = []
    for t_s in (0.0, 0.5):
        sea.set_time(t_s)
        waves = sea.sample(east, north, np.zeros(2), np.full_like(east, 0.05))
        profiles.append(waves.slope_east[0])
    shifts = np.arange(0, 24)
    match = [float(np.dot(profiles[0][:600], profiles[1][s : 600 + s])) for s in shifts]
    speed = shifts[int(np.argmax(match))] * 0.5 / 0.5
    assert speed == pytest.approx(7.9, abs=1.0)


def test_the_sea_stands_still_in_the_world() -> None:
    """Waves belong to places: another origin of coordinates shows the same water."""
    sea = Sea(Scene(seed=2))
    sea.set_time(5.0)
    east, north = _points(20.0, 48)
    pixel = np.full_like(east, 0.02)
    here = sea.sample(east, north, np.array([3.0, 4.0]), pixel)
    there = sea.sample(east - 7.0, north + 9.0, np.array([10.0, -5.0]), pixel)
    np.testing.assert_allclose(here.slope_east, there.slope_east, atol=2e-3)
