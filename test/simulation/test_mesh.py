# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Meshes: faces look outward, parts keep their own colours, and moving them moves nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.simulation.mesh import block, join, sheet, tube

SQUARE = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
FACES = [[0, 1, 2], [0, 2, 3]]


def volume(vertices, faces):
    """Return the volume that faces enclose, by the divergence theorem; negative inside out."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def test_a_sheet_has_one_colour_or_one_of_each_face():
    plain = sheet(SQUARE, FACES, (0.1, 0.2, 0.3), two_sided=True, nearer=0.5)
    assert plain.colours.tolist() == [[0.1, 0.2, 0.3]] * 2
    assert (plain.two_sided.tolist(), plain.nearer.tolist()) == ([True] * 2, [0.5] * 2)
    assert sheet(SQUARE, FACES, np.eye(3)[:2]).colours.tolist() == np.eye(3)[:2].tolist()


def test_joined_parts_keep_their_faces_and_colours():
    whole = join([sheet(SQUARE, FACES, 0.1), sheet(np.add(SQUARE, 5.0), FACES, 0.2, nearer=1.0)])
    assert whole.faces.tolist() == [*FACES, [4, 5, 6], [4, 6, 7]]
    assert whole.vertices[whole.faces[2]].tolist() == np.add(SQUARE, 5.0)[[0, 1, 2]].tolist()
    assert whole.colours[:, 0].tolist() == [0.1, 0.1, 0.2, 0.2]
    assert whole.nearer.tolist() == [0.0, 0.0, 1.0, 1.0]


def test_a_mesh_is_turned_and_then_moved():
    mesh = sheet(SQUARE, FACES, 0.5)
    placed = mesh.placed(matrix_from_rpy(0.0, 0.0, 0.5 * np.pi), (10.0, 0.0, 1.0))
    assert placed.vertices[1] == pytest.approx([10.0, 2.0, 1.0])
    assert placed.vertices[3] == pytest.approx([9.0, 0.0, 1.0])
    assert mesh.vertices.tolist() == SQUARE


@pytest.mark.parametrize("sides", [8, 12, 48])
def test_a_tube_is_closed_and_seen_from_outside(sides):
    """Half widths of 0.5 and 0.2 m, 3 m long: between the ellipse's section and the box's."""
    vertices, faces = tube([0.0, 1.0, 3.0], [0.5] * 3, [0.2] * 3, sides)
    edges = {tuple(face[[i, (i + 1) % 3]]) for face in faces for i in range(3)}
    assert edges == {(b, a) for a, b in edges}  # each edge has two faces, in both directions
    ellipse, box = 3.0 * np.pi * 0.5 * 0.2, 3.0 * 1.0 * 0.4
    assert 0.9 * ellipse < volume(vertices, faces) < box
    assert np.ptp(vertices, axis=0)[0] == 3.0
    assert (np.abs(vertices[:, 1:]) <= [0.5, 0.2]).all()


def test_a_block_is_closed_and_seen_from_outside():
    mesh = block((1.0, 3.0), (-2.0, -1.0), (0.0, 4.0), 0.5)
    edges = {tuple(face[[i, (i + 1) % 3]]) for face in mesh.faces for i in range(3)}
    assert edges == {(b, a) for a, b in edges}
    assert volume(mesh.vertices, mesh.faces) == pytest.approx(2.0 * 1.0 * 4.0)
