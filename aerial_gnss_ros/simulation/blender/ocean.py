# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The sea as a grid that follows the view, moved by Blender's FFT ocean modifiers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.blender import nodes
from aerial_gnss_ros.simulation.blender.shot import Shot
from aerial_gnss_ros.simulation.staging import View

Array = NDArray[np.float64]

STEP_PX = 2.0
MARGIN = 0.15
"""Margin of the grid as a share of the window's size: waves move the grid's edge."""
FARTHEST = np.radians(86.0)
"""Angle from the vertical to which flatter rays are bent down: the sea's edge is far away."""
FLOOR_DEPTH_M, FLOOR_HALF_M = 80.0, 3000.0
RESOLUTION = 14
"""Resolution of the modifiers: 196 waves along each side of a tile."""


def add_ocean(shot: Shot, time_s: float) -> tuple[Any, bool]:
    """Adds the sea without a material; its mean level is z = 0 at first.

    Three modifiers share the spectrum: tiles of a few times the view's width, of the view's
    width, and a fraction of it, so that waves from pixels to swell are there at any height.

    Returns:
        The object, and whether it has the attribute `FOAM`.
    """
    import bpy

    points, faces = _grid(shot.view)
    data = bpy.data.meshes.new("sea")
    data.from_pydata(points.tolist(), [], faces.tolist())
    data.polygons.foreach_set("use_smooth", np.full(len(faces), True))
    sea = bpy.data.objects.new("sea", data)
    bpy.context.scene.collection.objects.link(sea)
    nearest = _width_at(shot.view)
    tiles = [max(2.0, nearest * k) for k in (0.33, 1.3, 7.0)]
    slopes = _slopes(shot, tiles)
    foam = shot.scene.whitecaps > 0.0 and shot.scene.wind_speed > 4.0
    for i, (tile, slope) in enumerate(zip(tiles, slopes, strict=True)):
        wave = sea.modifiers.new(f"waves{i}", "OCEAN")
        wave.geometry_mode = "DISPLACE"
        wave.resolution = wave.viewport_resolution = RESOLUTION
        wave.spatial_size = max(1, round(tile))
        wave.spectrum = shot.sea.spectrum
        if shot.sea.spectrum in ("JONSWAP", "TEXEL_MARSEN_ARSLOE"):
            wave.fetch_jonswap = 60.0
        wave.wind_velocity = max(shot.scene.wind_speed, 2.0)
        wave.wave_direction = shot.scene.wind_yaw + 0.4 * (i - 1)
        wave.wave_alignment = 0.3 if i == 2 else 0.1
        wave.wave_scale_min = 0.0
        wave.choppiness = shot.sea.choppiness
        wave.depth = 200.0
        wave.random_seed = shot.scene.seed % 10_000 + i
        wave.time = time_s
        wave.wave_scale = _scale_for(wave, slope)
        if foam and i == 1:
            wave.use_foam = True
            wave.foam_layer_name = nodes.FOAM
            wave.foam_coverage = 0.02 * (shot.scene.wind_speed - 4.0) * shot.scene.whitecaps - 0.2
    return sea, foam


def add_floor() -> Any:
    """Adds a black bottom, which the waves' material needs: Cycles drops open volumes."""
    import bpy

    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * FLOOR_HALF_M
    data = bpy.data.meshes.new("floor")
    data.from_pydata([(x, y, -FLOOR_DEPTH_M) for x, y in corners.tolist()], [], [(0, 1, 2, 3)])
    data.materials.append(nodes.glowing((0.0, 0.0, 0.0)))
    floor = bpy.data.objects.new("floor", data)
    bpy.context.scene.collection.objects.link(floor)
    return floor


def _grid(view: View) -> tuple[Array, NDArray[np.int64]]:
    """Points of the water under every second pixel of the window and a margin, and quads."""
    window = view.window
    out = MARGIN * np.array([window.width, window.height])
    u = np.arange(window.x - out[0], window.x + window.width + out[0] + STEP_PX, STEP_PX)
    v = np.arange(window.y - out[1], window.y + window.height + out[1] + STEP_PX, STEP_PX)
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    k = view.camera.K
    optical = np.column_stack([(pixels - k[:2, 2]) / k[[0, 1], [0, 1]], np.ones(len(pixels))])
    rays = optical @ view.pose.enu_from_optical.T
    level = np.hypot(rays[:, 0], rays[:, 1])
    down = np.maximum(-rays[:, 2], level / np.tan(FARTHEST))
    points = np.zeros_like(rays)
    points[:, :2] = rays[:, :2] * (view.height / down)[:, None]
    index = np.arange(len(points)).reshape(len(v), len(u))
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1)
    return points, quads.reshape(-1, 4)


def _width_at(view: View) -> float:
    """Width in m of the window's view at the drawn pixel's distance."""
    k = view.camera.K
    ray = np.array([(view.pixel[0] - k[0, 2]) / k[0, 0], (view.pixel[1] - k[1, 2]) / k[1, 1], 1.0])
    down = -(view.pose.enu_from_optical @ ray)[2]
    return float(view.window.width / k[0, 0] * view.height / down)


def _slopes(shot: Shot, tiles: list[float]) -> list[float]:
    """Root mean square slopes of the three modifiers.

    Cox and Munk's mean square slope (1954) is spread evenly over the logarithm of the wavelength,
    as in the equilibrium range, from the wind sea's longest waves down to 2 cm.
    """
    wind = shot.scene.wind_speed
    total = 0.003 + 0.00512 * wind
    longest = max(0.8 * wind**2, 0.5)
    per_fold = total / np.log(longest / 0.02)
    edges = [tiles[0] / 60.0, tiles[0] / 2.0, tiles[1] / 2.0, tiles[2] / 2.0]
    folds = np.diff(np.log(np.clip(edges, 0.02, longest)))
    swell = np.array([0.0, 0.0, shot.scene.swell_slope])
    return [float(s) for s in np.sqrt(per_fold * folds + (0.7 * swell) ** 2) + 1e-4]


def _scale_for(wave: Any, slope: float) -> float:
    """The modifier's scale at which its waves have this slope: measured on a plain square."""
    import bpy

    wave.wave_scale = 1.0
    count, size = 128, float(wave.spatial_size)
    x = np.arange(count) * size / count
    points = np.column_stack([np.tile(x, count), np.repeat(x, count), np.zeros(count**2)])
    data = bpy.data.meshes.new("probe")
    data.from_pydata(points.tolist(), [], [])
    probe = bpy.data.objects.new("probe", data)
    bpy.context.scene.collection.objects.link(probe)
    copy = probe.modifiers.new("waves", "OCEAN")
    for key in ("geometry_mode", "resolution", "viewport_resolution", "spatial_size", "spectrum",
                "fetch_jonswap", "wind_velocity", "wave_direction", "wave_alignment", "wave_scale",
                "wave_scale_min", "depth", "random_seed", "time"):  # fmt: skip
        setattr(copy, key, getattr(wave, key))
    copy.choppiness = 0.0
    evaluated = probe.evaluated_get(bpy.context.evaluated_depsgraph_get())
    heights = np.empty((count**2, 3), np.float32)
    evaluated.data.vertices.foreach_get("co", heights.ravel())
    z = heights[:, 2].reshape(count, count)
    step = size / count
    rms = float(np.sqrt((np.diff(z, axis=0) ** 2).mean() + (np.diff(z, axis=1) ** 2).mean())) / step
    bpy.data.objects.remove(probe)
    bpy.data.meshes.remove(data)
    return slope / max(rms, 1e-9)
