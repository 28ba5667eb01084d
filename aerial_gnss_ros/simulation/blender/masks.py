# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Renders one glowing robot under clear water, as a reference for labels."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.blender import nodes, studio
from aerial_gnss_ros.simulation.view import Window

SEEN = 0.3
"""Of a pixel: a little less than half, since flippers' tips are narrow."""


def coverage(built: studio.Set, name: str, folder: Path) -> NDArray[np.float32]:
    """Share (height, width) of every pixel that a robot covers, with other robots hidden.

    Cycles refracts the lines of sight itself, so this shares only the mesh with `tracing`. It
    changes the set permanently.

    Args:
        built: the set.
        name: of the robot.
        folder: for a temporary file.
    """
    import bpy

    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("dark")
    scene.world.color = (0.0, 0.0, 0.0)
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    glow, dark = nodes.glowing((1.0, 1.0, 1.0)), nodes.glowing((0.0, 0.0, 0.0))
    built.sea.data.materials[0] = nodes.window_pane()
    studio.hide([*built.robots.values(), built.props])
    studio.hide([built.robots[name]], hidden=False)
    for thing in built.robots[name]:
        thing.data.materials[0] = glow
    for thing in bpy.data.objects:
        if thing.name.startswith("floor"):
            thing.data.materials[0] = dark
    share: NDArray[np.float32] = studio.render_pass(folder)[..., 1]
    return share


def box_of(share: NDArray[np.float32], window: Window) -> tuple[float, float, float, float] | None:
    """Left, top, right, bottom of the pixels that a robot covers, in pixels of the whole image."""
    rows, columns = np.nonzero(share > SEEN)
    if not len(rows):
        return None
    x, y = window.x - 0.5, window.y - 0.5
    return (
        x + float(columns.min()), y + float(rows.min()),
        x + float(columns.max()) + 1.0, y + float(rows.max()) + 1.0,
    )  # fmt: skip
