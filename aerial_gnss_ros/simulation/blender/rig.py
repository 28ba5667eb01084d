# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Builds Blender objects: meshes with a colour per face, and robots with jointed flippers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.blender import nodes
from aerial_gnss_ros.simulation.blender.hexapod import (
    ROWS,
    SIDES,
    Robot,
    deck,
    flipper_halves,
    hip,
    hull,
)
from aerial_gnss_ros.simulation.mesh import Mesh, join

Array = NDArray[np.float64]


def add_mesh(name: str, mesh: Mesh, material: Any, smooth: bool = False) -> Any:
    """Adds an object of triangles with their colours; returns it."""
    import bpy

    data = bpy.data.meshes.new(name)
    data.from_pydata(mesh.vertices.tolist(), [], mesh.faces.tolist())
    layer = data.attributes.new(nodes.COLOURS, "FLOAT_COLOR", "FACE")
    rgba = np.column_stack([mesh.colours[:, ::-1], np.ones(len(mesh.faces))])
    layer.data.foreach_set("color", rgba.astype(np.float32).ravel())
    data.polygons.foreach_set("use_smooth", np.full(len(mesh.faces), smooth))
    data.materials.append(material)
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def add_robot(robot: Robot, height: float) -> list[Any]:
    """Adds a robot as a tree of objects: hull, deck, hips, two halves of every flipper.

    Args:
        robot: shape, pose and place.
        height: of the hull's middle, m, Blender's z.

    Returns:
        The hull first, then all its parts; a robot of another shape is one object.
    """
    if robot.mesh is not None:
        body = add_mesh(robot.robot_id, robot.mesh, nodes.painted(robot.build.roughness))
        _place(body, robot, height)
        return [body]
    build = robot.build
    paint = nodes.painted(build.roughness, build.paint.metallic)
    rubber = nodes.painted(0.55)
    body = add_mesh(robot.robot_id, hull(build), paint, smooth=True)
    _place(body, robot, height)
    parts = [_child(body, add_mesh("deck", join(deck(build)), rubber))]
    inner, outer = flipper_halves(build)
    for i, row in enumerate(ROWS):
        for j, side in enumerate(SIDES):
            pose = robot.flippers[2 * i + j]
            joint = _child(body, add_mesh("hip", hip(build), rubber, smooth=True))
            outward = build.width / 2.0 + build.flipper_width / 2.0 + 0.005
            joint.location = (row * build.hips, side * outward, 0.0)
            # A positive turn about y lifts what trails behind.
            joint.rotation_euler = (0.0, pose.swing, 0.0)
            root = _child(joint, add_mesh("inner", inner, rubber, smooth=True))
            root.rotation_euler = (0.0, 0.0, -side * pose.splay)
            tip = _child(root, add_mesh("outer", outer, rubber, smooth=True))
            tip.location = (-build.flipper_length / 2.0, 0.0, 0.0)
            tip.rotation_euler = (0.0, pose.bend, 0.0)
            parts += [joint, root, tip]
    return [body, *parts]


def _place(body: Any, robot: Robot, height: float) -> None:
    body.location = (robot.east, robot.north, height)
    body.rotation_euler = (robot.roll, robot.pitch, robot.course)


def _child(parent: Any, thing: Any) -> Any:
    thing.parent = parent
    return thing


def world_triangles(things: list[Any]) -> tuple[Array, NDArray[np.int64]]:
    """Vertices (n, 3) in the world and triangles (m, 3) of objects as they are rendered."""
    import bpy

    graph = bpy.context.evaluated_depsgraph_get()
    points, faces, start = [], [], 0
    for thing in things:
        evaluated = thing.evaluated_get(graph)
        mesh = evaluated.to_mesh()
        mesh.calc_loop_triangles()
        local = np.empty((len(mesh.vertices), 3), np.float32)
        mesh.vertices.foreach_get("co", local.ravel())
        triangles = np.empty((len(mesh.loop_triangles), 3), np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles.ravel())
        matrix = np.array(evaluated.matrix_world)
        points.append(local @ matrix[:3, :3].T + matrix[:3, 3])
        faces.append(triangles.astype(np.int64) + start)
        start += len(local)
        evaluated.to_mesh_clear()
    return np.concatenate(points), np.concatenate(faces)
