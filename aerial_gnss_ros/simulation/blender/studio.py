# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sets a shot up in Blender and renders it with Cycles to linear light."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.blender import nodes
from aerial_gnss_ros.simulation.blender.ocean import add_floor, add_ocean
from aerial_gnss_ros.simulation.blender.rig import add_mesh, add_robot
from aerial_gnss_ros.simulation.blender.shot import Shot
from aerial_gnss_ros.simulation.staging import View
from aerial_gnss_ros.simulation.view import Window

F32 = NDArray[np.float32]
SENSOR_MM = 36.0


@dataclass(frozen=True)
class Set:
    """Objects of Blender's scene.

    Attributes:
        shot: what it was built from.
        sea: the water's object.
        mirror, body: its materials, whose pictures add up (nodes.water).
        robots: objects of each robot, by its name.
        props: the other things.
    """

    shot: Shot
    sea: Any
    mirror: Any
    body: Any
    robots: dict[str, list[Any]]
    props: list[Any]


def build(shot: Shot, samples: int, seed: int) -> Set:
    """Clears Blender and builds the shot.

    Args:
        shot: what to build.
        samples: paths per pixel.
        seed: of the paths.
    """
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    _settings(samples, seed, nodes.daylight(shot))
    _camera(shot.view)
    nodes.sky(shot)
    sea, foam = add_ocean(shot, time_s=float(shot.scene.seed % 97))
    mirror, body = nodes.water(shot, foam)
    sea.data.materials.append(body)
    add_floor()
    level = Level(sea)
    # The window was drawn for a robot at height 0 in it: the waves are moved so that it is there.
    if shot.robots:
        sea.location.z = -level.at(shot.robots[0].east, shot.robots[0].north)
        level = Level(sea)
    robots = {r.robot_id: add_robot(r, level.at(r.east, r.north) - r.depth) for r in shot.robots}
    material = nodes.painted(0.45)
    props = []
    for i, prop in enumerate(shot.props):
        thing = add_mesh(f"prop{i}", prop.mesh, material)
        thing.location = (prop.east, prop.north, level.at(prop.east, prop.north))
        props.append(thing)
    return Set(shot, sea, mirror, body, robots, props)


class Level:
    """Height of the waves, smoothed over a robot's size."""

    def __init__(self, sea: Any) -> None:
        from mathutils.bvhtree import BVHTree

        from aerial_gnss_ros.simulation.blender.rig import world_triangles

        points, faces = world_triangles([sea])
        self._tree = BVHTree.FromPolygons(points.tolist(), faces.tolist())

    def at(self, east: float, north: float) -> float:
        """Mean height around a position, m; 0 outside the sea."""
        heights = []
        for de, dn in ((0.0, 0.0), (0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2)):
            hit = self._tree.ray_cast((east + de, north + dn, 100.0), (0.0, 0.0, -1.0))[0]
            if hit is not None:
                heights.append(hit.z)
        return float(np.mean(heights)) if heights else 0.0


def hide(robots: list[list[Any]], hidden: bool = True) -> None:
    """Hides robots from the image, or shows them again."""
    for things in robots:
        for thing in things:
            thing.hide_render = hidden


def _settings(samples: int, seed: int, white: float) -> None:
    import bpy

    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.use_persistent_data = True  # the second picture, without robots, is cheap
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.seed = "CPU", samples, seed
    cycles.use_adaptive_sampling = False
    cycles.use_denoising, cycles.denoiser = True, "OPENIMAGEDENOISE"
    cycles.denoising_prefilter, cycles.denoising_quality = "NONE", "FAST"
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 5, 1, 2
    cycles.transmission_bounces, cycles.volume_bounces = 4, 0
    cycles.transparent_max_bounces = 6
    cycles.caustics_reflective = cycles.caustics_refractive = False
    # Fireflies beyond what the tone curve shows as white.
    cycles.sample_clamp_direct, cycles.sample_clamp_indirect = 2.5 * white, 1.5 * white


def _camera(view: View) -> None:
    """The window's part of the camera's image, as a camera of its own with a shifted sensor."""
    import bpy
    from mathutils import Matrix

    window, scene = view.window, bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = window.width, window.height
    data = bpy.data.cameras.new("camera")
    camera = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(camera)
    scene.camera = camera
    k = view.camera.K
    data.sensor_fit, data.sensor_width = "HORIZONTAL", SENSOR_MM
    data.lens = float(k[0, 0]) / window.width * SENSOR_MM
    data.clip_start, data.clip_end = 0.1, 20_000.0
    # Pixel centres have whole coordinates here; the window's middle is half a pixel off.
    data.shift_x = (window.x + (window.width - 1) / 2 - float(k[0, 2])) / window.width
    data.shift_y = -(window.y + (window.height - 1) / 2 - float(k[1, 2])) / window.width
    matrix = np.eye(4)
    # Blender's camera looks along -z with y up; the optical frame along z with y down.
    matrix[:3, :3] = view.pose.enu_from_optical @ np.diag([1.0, -1.0, -1.0])
    matrix[:3, 3] = view.pose.position
    camera.matrix_world = Matrix(matrix.tolist())


def render(built: Set, folder: Path, part: Window | None = None) -> F32:
    """Renders what stands there: what the waves mirror, plus all the rest.

    Args:
        built: the set.
        folder: for passing files.
        part: only this part of the picture, from its first pixel.

    Returns:
        (height, width, 3) blue, green, red, linear, in the sky's units.
    """
    import bpy

    cycles = bpy.context.scene.cycles
    things = [*(thing for robot in built.robots.values() for thing in robot), *built.props]
    built.sea.data.materials[0] = built.mirror
    cycles.use_denoising = False  # smooth already, but for glints, which it would take for noise
    for thing in things:
        thing.is_holdout = True  # black, but mirrored
    mirrored = render_pass(folder, part)
    built.sea.data.materials[0] = built.body
    cycles.use_denoising = True
    for thing in things:
        thing.is_holdout = False
    return mirrored + render_pass(folder, part)


def render_pass(folder: Path, part: Window | None = None) -> F32:
    """Renders the scene as it is; for the rest see `render`."""
    import bpy

    scene = bpy.context.scene
    width, height = scene.render.resolution_x, scene.render.resolution_y
    scene.render.use_border = scene.render.use_crop_to_border = part is not None
    if part is not None:
        scene.render.border_min_x = part.x / width
        scene.render.border_max_x = (part.x + part.width) / width
        scene.render.border_min_y = 1.0 - (part.y + part.height) / height
        scene.render.border_max_y = 1.0 - part.y / height
    path = folder / "linear.exr"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    try:
        columns, rows = image.size
        values = np.empty(rows * columns * image.channels, np.float32)
        image.pixels.foreach_get(values)
    finally:
        bpy.data.images.remove(image)
        path.unlink()
    # Blender counts rows from below.
    picture = values.reshape(rows, columns, -1)[::-1, :, 2::-1]
    return np.ascontiguousarray(np.nan_to_num(picture))
