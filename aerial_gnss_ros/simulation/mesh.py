# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Small triangle meshes with a colour per face: robots and other floating things."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Mesh:
    """Triangles.

    Attributes:
        vertices: (n, 3) m.
        faces: (m, 3) vertex indices, counter-clockwise seen from outside.
        colours: (m, 3) reflectance blue, green, red, 0 to 1, linear.
        two_sided: (m,) whether the face is a thin sheet seen from both sides.
        nearer: (m,) m by which the face is drawn as if nearer: decks over hulls.
    """

    vertices: Array
    faces: NDArray[np.int64]
    colours: Array
    two_sided: NDArray[np.bool_]
    nearer: Array

    def placed(self, rotation: Array, position: ArrayLike) -> Mesh:
        """The mesh rotated by (3, 3) and moved by (3,)."""
        vertices = self.vertices @ rotation.T + np.asarray(position, dtype=np.float64)
        return Mesh(vertices, self.faces, self.colours, self.two_sided, self.nearer)


def sheet(
    vertices: ArrayLike,
    faces: ArrayLike,
    colour: ArrayLike,
    two_sided: bool = False,
    nearer: float = 0.0,
) -> Mesh:
    """A mesh of one colour (3,) or of a colour per face (m, 3)."""
    f = np.asarray(faces, dtype=np.int64).reshape(-1, 3)
    m = len(f)
    return Mesh(
        np.asarray(vertices, dtype=np.float64).reshape(-1, 3),
        f,
        np.broadcast_to(np.asarray(colour, dtype=np.float64), (m, 3)).copy(),
        np.full(m, two_sided),
        np.full(m, nearer),
    )


def join(parts: list[Mesh]) -> Mesh:
    """All parts as one mesh."""
    starts = np.cumsum([0] + [len(p.vertices) for p in parts[:-1]])
    return Mesh(
        np.concatenate([p.vertices for p in parts]),
        np.concatenate([p.faces + s for p, s in zip(parts, starts, strict=True)]),
        np.concatenate([p.colours for p in parts]),
        np.concatenate([p.two_sided for p in parts]),
        np.concatenate([p.nearer for p in parts]),
    )


def block(
    x: tuple[float, float],
    y: tuple[float, float],
    z: tuple[float, float],
    colour: ArrayLike,
    nearer: float = 0.0,
) -> Mesh:
    """A cuboid between two values of each axis, m."""
    corners = np.array([(a, b, c) for a in x for b in y for c in z])
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    faces = np.array([half for a, b, c, d in sides for half in ((a, b, c), (a, c, d))])
    return sheet(corners, _outward(corners, faces), colour, nearer=nearer)


def tube(
    stations: ArrayLike,
    half_widths: ArrayLike,
    half_heights: ArrayLike,
    sides: int = 12,
    roundness: float = 0.5,
) -> tuple[Array, NDArray[np.int64]]:
    """A closed body along x with rounded rectangular sections.

    Args:
        stations: (n,) x of the sections, increasing, m.
        half_widths: (n,) of the sections, m.
        half_heights: (n,) of the sections, m.
        sides: Corners of a section.
        roundness: 1 for an ellipse, 0.5 for a superellipse of exponent 4.

    Returns:
        Vertices (n * sides, 3) and faces.
    """
    x = np.asarray(stations, dtype=np.float64)
    angle = (np.arange(sides) + 0.5) * 2.0 * np.pi / sides
    # Superellipse of exponent 2 / roundness; of 4 it lies between a rectangle and an ellipse.
    cy = np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** roundness
    cz = np.sign(np.sin(angle)) * np.abs(np.sin(angle)) ** roundness
    y = np.asarray(half_widths, dtype=np.float64)[:, None] * cy
    z = np.asarray(half_heights, dtype=np.float64)[:, None] * cz
    vertices = np.stack([np.broadcast_to(x[:, None], y.shape), y, z], axis=-1).reshape(-1, 3)
    faces = []
    for i in range(len(x) - 1):
        for j in range(sides):
            a, b = i * sides + j, i * sides + (j + 1) % sides
            c, d = a + sides, b + sides
            faces += [(a, c, b), (b, c, d)]
    last = (len(x) - 1) * sides
    for j in range(1, sides - 1):
        faces += [(0, j, j + 1), (last, last + j + 1, last + j)]
    return vertices, _outward(vertices, np.array(faces, dtype=np.int64))


def _outward(vertices: Array, faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Turns faces of a convex-like body so that all normals point away from its middle."""
    corner = vertices[faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    inward = np.einsum("ij,ij->i", normal, corner.mean(axis=1) - vertices.mean(axis=0)) < 0.0
    faces = faces.copy()
    faces[inward] = faces[inward][:, ::-1]
    return faces
