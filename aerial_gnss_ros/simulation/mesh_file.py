# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads the shape of a robot from a mesh file: OBJ or glTF, by trimesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.resources import install_hint
from aerial_gnss_ros.simulation.mesh import Array, Mesh, join

ENDINGS = (".obj", ".gltf", ".glb")
MOST_FACES = 20_000
"""Each takes tens of microseconds in each image."""
LENGTHS_M = (0.05, 20.0)
_GLTF = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""To x forward, y left, z up: glTF 2.0, section 3.4, has z forward, x left, y up."""


def read_mesh(path: Path) -> tuple[Mesh, NDArray[np.bool_]]:
    """Return a robot's mesh, and which of its faces (m,) have a colour in the file.

    A file states metres, its origin being the point of the robot that is at the waterline when it
    floats: glTF in its own axes, OBJ, which has none, with x forward, y left and z up.

    Args:
        path: of the file.

    Raises:
        ConfigError: no such file, no mesh, or none of a robot's size; trimesh is not installed.
    """
    if not path.is_file():
        raise ConfigError(f"the robot model {path} does not exist.")
    try:
        import trimesh
    except ImportError as error:
        raise ConfigError(
            f"a robot model from a file needs trimesh; install it with {install_hint('mesh')}."
        ) from error
    is_gltf = path.suffix.lower() != ".obj"
    try:
        parts = [_part(one, is_gltf) for one in trimesh.load_scene(path).dump() if _has_faces(one)]
    except Exception as error:  # trimesh has no common error
        raise ConfigError(f"{path} cannot be read as a mesh ({error}).") from error
    if not parts:
        raise ConfigError(f"{path} has no triangles; export the robot as a mesh.")
    mesh = join([part for part, _ in parts])
    if is_gltf:
        mesh = mesh.placed(_GLTF, (0.0, 0.0, 0.0))
    _check(path, mesh)
    return mesh, np.concatenate([coloured for _, coloured in parts])


def _has_faces(part: Any) -> bool:
    return len(getattr(part, "faces", ())) > 0


def _part(part: Any, is_gltf: bool) -> tuple[Mesh, NDArray[np.bool_]]:
    """Return one body, with faces outward if it is closed, and seen from both sides if not."""
    found = _reflectance(part, is_gltf)
    count = len(part.faces)
    colours = np.ones((count, 3)) if found is None else found[:, ::-1]
    part.merge_vertices(merge_tex=True, merge_norm=True)  # files repeat them at every edge
    faces = np.asarray(part.faces, dtype=np.int64)
    closed = bool(part.is_watertight)
    if closed and part.volume < 0.0:
        faces = faces[:, ::-1].copy()
    mesh = Mesh(
        np.asarray(part.vertices, dtype=np.float64), faces, colours, np.full(count, not closed),
        np.zeros(count),
    )  # fmt: skip
    return mesh, np.full(count, found is not None)


def _reflectance(part: Any, is_gltf: bool) -> Array | None:
    """Return red, green, blue (m, 3) of the faces, 0 to 1; None: the file states no colour."""
    visual = part.visual
    if not visual.defined:
        return None
    if visual.kind != "texture":
        levels = np.asarray(visual.face_colors, dtype=np.float64)[:, :3]
    elif visual.uv is not None and _picture(visual.material) is not None:
        vertices = np.asarray(visual.to_color().vertex_colors, dtype=np.float64)[:, :3]
        return _linear(vertices[part.faces].mean(axis=1) / 255.0)  # pictures are sRGB in both
    else:
        levels = np.tile(np.asarray(visual.material.main_color)[:3], (len(part.faces), 1))
    return np.asarray(levels / 255.0) if is_gltf else _linear(levels / 255.0)


def _picture(material: Any) -> Any:
    return getattr(material, "image", None) or getattr(material, "baseColorTexture", None)


def _linear(value: Array) -> Array:
    """Return reflectances of sRGB values, 0 to 1 (IEC 61966-2-1)."""
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def _check(path: Path, mesh: Mesh) -> None:
    if len(mesh.faces) > MOST_FACES:
        raise ConfigError(
            f"{path} has {len(mesh.faces)} triangles, which take too long to render; reduce it to "
            f"{MOST_FACES} or less (in Blender: modifier Decimate)."
        )
    size = np.ptp(mesh.vertices, axis=0)
    low, high = LENGTHS_M
    if not low <= size.max() <= high:
        raise ConfigError(
            f"{path} is {size[0]:.3g} x {size[1]:.3g} x {size[2]:.3g} m large, and a robot "
            f"measures {low:g} to {high:g} m; scale it to metres."
        )
