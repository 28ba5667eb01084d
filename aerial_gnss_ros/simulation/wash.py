# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Effects of a robot on the water around it: shadow, wake, foam at the waterline."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.hexapod import LENGTH, RobotState
from aerial_gnss_ros.simulation.planes import F32, remap
from aerial_gnss_ros.simulation.robot_models import robot_model
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.shading import Water

WAKE_LENGTH = 3.2
"""m behind the robot's middle where its wake has faded away."""


def reach_points(state: RobotState, scene: Scene) -> NDArray[np.float64]:
    """Corners (n, 3) on the surface of the area that `disturb` changes."""
    forward = np.array([np.cos(state.course), np.sin(state.course)])
    left = np.array([-forward[1], forward[0]])
    middle = np.array([state.east, state.north])
    back = WAKE_LENGTH if state.speed > 0.05 else 1.0
    larger = max(1.0, *robot_model(state.model).scale)
    corners = [
        middle + larger * (a * forward + b * left)
        for a, b in ((1.0, 1.0), (1.0, -1.0), (-back, -1.5), (-back, 1.5))
    ]
    away = -scene.sun_direction[:2] / max(scene.sun_direction[2], 0.3)
    sides = larger * 0.6 * np.array([(-1, 0), (1, 0), (0, -1), (0, 1)])
    corners += [middle + 0.9 * away + side for side in sides]
    return np.array([[c[0], c[1], 0.0] for c in corners])


def disturb(water: Water, state: RobotState, scene: Scene) -> None:
    """Changes the water block in place: shadow on what glows below, wake slopes and foam."""
    dx = water.east - np.float32(state.east - water.origin[0])
    dy = water.north - np.float32(state.north - water.origin[1])
    c, s = np.float32(np.cos(state.course)), np.float32(np.sin(state.course))
    along, across = dx * c + dy * s, dy * c - dx * s
    _shadow(water, state, scene, along, across)
    strength = np.exp(-max(state.depth - 0.03, 0.0) / 0.12) * min(state.speed / 0.4, 1.5)
    if strength > 0.03:
        _wake(water, state, along, across, float(strength))


def _shadow(water: Water, state: RobotState, scene: Scene, along: F32, across: F32) -> None:
    """Sunlight missing from the water column under the robot, softened by scattering."""
    if scene.sun_light < 0.1:
        return
    # Most of the glow comes from the first mean free path; deeper water blurs the shadow.
    reach = float(np.clip(0.5 / max(scene.attenuation[1], 0.1), 0.25, 1.2))
    flat = scene.sun_direction[:2] / 1.34
    slant = flat / np.sqrt(1.0 - flat @ flat)
    c, s = np.cos(state.course), np.sin(state.course)
    shift = -(slant[0] * c + slant[1] * s) * reach, -(slant[1] * c - slant[0] * s) * reach
    longer, wider = robot_model(state.model).scale
    a, b = 0.5 * LENGTH * longer + 0.22 * reach, 0.2 * wider + 0.22 * reach
    square = ((along - np.float32(shift[0])) / np.float32(a)) ** 2
    square += ((across - np.float32(shift[1])) / np.float32(b)) ** 2
    dark = np.exp(-square)
    dark *= np.float32(0.45 * scene.sun_light / (1.0 + reach) ** 0.5)
    np.subtract(1.0, dark, out=dark)
    for i in range(3):
        water.glow[i] *= dark


def _wake(water: Water, state: RobotState, along: F32, across: F32, strength: float) -> None:
    """Kelvin's two arms at 19.5 degrees, a smooth turbulent strip between, a little foam."""
    longer, wider = robot_model(state.model).scale
    behind = np.float32(0.25 * longer) - along
    aft = np.maximum(behind, 0.0)
    arm = np.abs(across) - aft * np.float32(0.354) - np.float32(0.1 * wider)
    width = 0.06 + 0.05 * aft
    fade = np.exp(-aft / np.float32(1.1)) * (behind > 0.0)
    speed = max(state.speed, 0.15)
    number = np.float32(9.81 / speed**2)  # wavenumber of waves that keep up with the robot
    crest = np.exp(-((arm / width) ** 2)) * fade
    ripple = np.cos(np.minimum(number, np.float32(60.0)) * (aft * 0.82 + np.abs(across) * 0.57))
    slope = ripple * crest * np.float32(0.2 * strength)
    side = np.sign(across)
    c, s = np.float32(np.cos(state.course)), np.float32(np.sin(state.course))
    waves = water.waves
    # Divergent waves travel outwards at 35 degrees to the course.
    strip = np.exp(-((across / (0.13 + 0.04 * aft)) ** 2)) * fade
    calm = 1.0 - np.float32(0.6 * min(strength, 1.0)) * strip
    waves.slope_east[:] = waves.slope_east * calm + slope * (0.82 * -c + 0.57 * side * -s)
    waves.slope_north[:] = waves.slope_north * calm + slope * (0.82 * -s + 0.57 * side * c)
    foam = strip * np.exp(-aft / np.float32(0.6)) * np.float32(0.42 * strength)
    # Water piles up and breaks at the hull.
    rim = (np.abs(along) / np.float32(0.36 * longer)) ** 4
    rim += (np.abs(across) / np.float32(0.2 * wider)) ** 4
    foam += np.exp(-(((rim - 1.0) / 0.9) ** 2)) * np.float32(0.22 * strength)
    foam *= np.clip(0.45 + 0.75 * water.sea.lumps(water.east, water.north, water.origin), 0.0, 1.6)
    np.minimum(foam, 0.8, out=foam)
    if waves.foam is None:
        water.waves = type(waves)(waves.slope_east, waves.slope_north, waves.variance, foam)
    else:
        np.maximum(waves.foam, foam, out=waves.foam)


def wobble(layer: F32, slope_right: F32, slope_down: F32, gain: float) -> F32:
    """Shifts a submerged layer (h, w, 3) by the waves' slopes above it (pixels = slope x gain)."""
    h, w = layer.shape[:2]
    x, y = np.meshgrid(np.arange(w, dtype=np.float32), np.arange(h, dtype=np.float32))
    return remap(layer, x + slope_right * np.float32(gain), y + slope_down * np.float32(gain))
