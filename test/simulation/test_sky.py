# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Light of the sky by direction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.sky import Sky

CLEAR = replace(Scene(), sun_light=0.0, cloud_cover=0.0)


def look(sky, *directions):
    """Return the radiance (n, 3) towards unit directions (n, 3)."""
    rays = np.array(directions, np.float32)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    planes = sky.look(*(rays[None, :, i].copy() for i in range(3)))
    return np.stack([plane[0] for plane in planes], axis=1)


def test_without_sun_and_clouds_colours_go_from_the_horizon_to_the_zenith():
    sky = Sky(CLEAR)
    up, level, half = look(sky, (0, 0, 1), (1, 0, 1e-3), (0, 1, np.tan(np.radians(30.0))))
    assert up == pytest.approx(CLEAR.sky_zenith, rel=0.01)
    assert level == pytest.approx(CLEAR.sky_horizon, rel=0.06)
    share = np.sqrt(0.5)
    expected = share * np.array(CLEAR.sky_zenith) + (1.0 - share) * np.array(CLEAR.sky_horizon)
    assert half == pytest.approx(expected, rel=0.01)
    ring = look(sky, *[(np.cos(a), np.sin(a), 1.0) for a in np.linspace(0.0, 6.0, 9)])
    assert np.ptp(ring, axis=0) == pytest.approx([0.0] * 3, abs=1e-3)


def test_a_sky_of_one_colour_lights_a_level_sheet_with_it():
    sky = Sky(replace(CLEAR, sky_zenith=(0.3, 0.2, 0.1), sky_horizon=(0.3, 0.2, 0.1)))
    assert sky.irradiance == pytest.approx([0.3, 0.2, 0.1])
    assert sky.horizon == pytest.approx([0.3, 0.2, 0.1])


def test_it_is_brightest_where_the_sun_stands():
    scene = replace(CLEAR, sun_light=0.8)
    sky, sun = Sky(scene), scene.sun_direction
    aside = np.array([-sun[0], -sun[1], sun[2]])
    at, away = look(sky, sun, aside)
    assert (at > 2.0 * away).all()
    assert (sky.irradiance > Sky(CLEAR).irradiance).all()


@pytest.mark.parametrize("cover", [0.2, 0.8])
def test_clouds_cover_more_or_less_of_it_and_are_those_of_the_seed(cover):
    rng = np.random.default_rng(1)
    rays = rng.standard_normal((4000, 3))
    rays[:, 2] = np.abs(rays[:, 2]) + 0.5
    clear, one, again, other = (
        look(Sky(scene), *rays)
        for scene in (
            CLEAR,
            replace(CLEAR, cloud_cover=cover),
            replace(CLEAR, cloud_cover=cover),
            replace(CLEAR, cloud_cover=cover, seed=7),
        )
    )
    assert (one == again).all()
    assert (one != other).any()
    covered = (np.abs(one - clear) > 0.02).any(axis=1).mean()
    assert covered == pytest.approx(cover, abs=0.2)
