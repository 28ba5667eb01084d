# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Distractors: objects at sea that a detector must learn to ignore."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.mesh import Mesh, join, sheet, tube

Array = NDArray[np.float64]

PAINT = (
    (0.03, 0.05, 0.65),
    (0.03, 0.25, 0.75),
    (0.03, 0.50, 0.75),
    (0.75, 0.75, 0.75),
    (0.10, 0.40, 0.08),
    (0.45, 0.20, 0.05),
    (0.04, 0.04, 0.04),
    (0.30, 0.32, 0.34),
)

SKIN = ((0.20, 0.30, 0.52), (0.13, 0.22, 0.42), (0.06, 0.11, 0.24), (0.03, 0.05, 0.11))
HAIR = ((0.01, 0.01, 0.02), (0.02, 0.04, 0.08), (0.12, 0.25, 0.38), (0.30, 0.30, 0.30))


def buoy(rng: np.random.Generator) -> Mesh:
    """A ball or can buoy, 0.2 to 0.9 m across, with a band or a mast."""
    radius = float(np.exp(rng.uniform(np.log(0.1), np.log(0.45))))
    paint = _paint(rng)
    angle = np.linspace(-np.pi / 2, np.pi / 2, 7)[1:-1]
    flat = rng.uniform(0.6, 1.6)
    vertices, faces = tube(
        radius * flat * np.sin(angle), radius * np.cos(angle), radius * np.cos(angle), sides=10
    )
    upright = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    vertices = vertices @ upright.T
    colours = np.tile(paint, (len(faces), 1))
    if rng.random() < 0.4:
        colours[np.abs(vertices[faces].mean(axis=1)[:, 2]) < 0.3 * radius] = _paint(rng)
    parts = [sheet(vertices, faces, colours)]
    if rng.random() < 0.4:
        mast, mast_faces = tube((0.0, radius * 3.0), (0.03, 0.03), (0.03, 0.03), sides=5)
        parts.append(sheet(mast @ upright.T, mast_faces, _paint(rng)))
    return join(parts).placed(np.eye(3), (0.0, 0.0, rng.uniform(-0.3, 0.4) * radius))


def bird(rng: np.random.Generator) -> Mesh:
    """A sea bird swimming, or flying a little over the water."""
    body = np.array((0.72, 0.72, 0.70) if rng.random() < 0.7 else (0.06, 0.06, 0.07))
    size = rng.uniform(0.7, 1.3)
    vertices, faces = tube(
        size * np.array([-0.22, -0.12, 0.08, 0.2, 0.26]),
        size * np.array([0.02, 0.07, 0.08, 0.04, 0.015]),
        size * np.array([0.01, 0.05, 0.06, 0.04, 0.015]),
        sides=8,
    )
    parts = [sheet(vertices, faces, body)]
    height = 0.03
    if rng.random() < 0.5:
        height = rng.uniform(0.5, 4.0)
        lift = rng.uniform(-0.15, 0.3)
        grey = np.clip(body * rng.uniform(0.4, 1.0), 0.0, 1.0)
        for side in (-1.0, 1.0):
            y = side * size * np.array([0.05, 0.3, 0.62])
            z = np.array([0.02, 0.02 + lift * 0.6, 0.02 + lift])
            wing = [
                (0.10 * size, y[0], z[0]), (0.14 * size, y[1], z[1]), (-0.08 * size, y[2], z[2]),
                (-0.04 * size, y[1], z[1]), (-0.08 * size, y[0], z[0]),
            ]  # fmt: skip
            parts.append(sheet(wing, [(0, 1, 4), (1, 3, 4), (1, 2, 3)], grey, two_sided=True))
    return join(parts).placed(np.eye(3), (0.0, 0.0, height))


def weed(rng: np.random.Generator) -> Mesh:
    """A mat of floating weed or a lump of debris just at or under the surface."""
    brown = np.array([0.02, 0.06, 0.09]) * rng.uniform(0.5, 2.2) + rng.uniform(0, 0.02, 3)
    stretch = rng.uniform(1.0, 5.0)
    size = float(np.exp(rng.uniform(np.log(0.12), np.log(0.8))))
    parts = []
    for _ in range(int(rng.integers(2, 9))):
        n = 9
        radius = size * rng.uniform(0.2, 0.6) * rng.uniform(0.5, 1.0, n)
        angle = np.arange(n) * 2 * np.pi / n
        x = stretch * (radius * np.cos(angle) + size * rng.normal(0.0, 0.4))
        y = radius * np.sin(angle) + size * rng.normal(0.0, 0.4)
        z = np.full(n, -abs(rng.normal(0.0, 0.12)))
        ring = np.stack([x, y, z], axis=-1)
        fan = [(0, i, i + 1) for i in range(1, n - 1)]
        parts.append(sheet(ring, fan, brown * rng.uniform(0.7, 1.3), two_sided=True))
    return join(parts)


def boat(rng: np.random.Generator) -> Mesh:
    """A kayak, dinghy or small motor boat, 2 to 8 m long."""
    length = float(np.exp(rng.uniform(np.log(2.0), np.log(8.0))))
    beam = length * rng.uniform(0.16, 0.4)
    x = length * np.array([-0.5, -0.45, -0.1, 0.25, 0.45, 0.5])
    width = 0.5 * beam * np.array([0.75, 0.85, 1.0, 0.8, 0.25, 0.04])
    high = 0.09 * length * np.array([0.6, 0.7, 0.7, 0.7, 0.6, 0.4])
    vertices, faces = tube(x, width, high, sides=10)
    parts = [sheet(vertices, faces, _paint(rng))]
    inner = 0.72
    top = 0.09 * length * 0.71
    outline = [(a, b * inner, top) for a, b in zip(x[1:5], width[1:5], strict=True)]
    outline += [(a, -b * inner, top) for a, b in zip(x[4:0:-1], width[4:0:-1], strict=True)]
    fan = [(0, i + 1, i) for i in range(1, len(outline) - 1)]
    parts.append(sheet(outline, fan, _paint(rng) * 0.6, two_sided=True, nearer=5.0))
    for _ in range(int(rng.integers(0, 4))):
        block, block_faces = tube((-0.3, 0.3), (0.25, 0.25), (0.25, 0.2), sides=6)
        move = (rng.uniform(-0.3, 0.2) * length, 0.0, top + 0.1)
        one = sheet(block * rng.uniform(0.5, 1.2), block_faces, _paint(rng), nearer=6.0)
        parts.append(one.placed(np.eye(3), move))
    return join(parts)


def plank(rng: np.random.Generator) -> Mesh:
    """Rubbish: a plank, a box, a barrel or a bottle. Close in size to a robot, without its legs."""
    length = float(np.exp(rng.uniform(np.log(0.15), np.log(1.5))))
    width = length * rng.uniform(0.08, 0.8)
    sides = int(rng.choice([4, 6, 12]))
    vertices, faces = tube(
        (-length / 2, length / 2), (width / 2, width / 2), (width / 3, width / 3), sides=sides
    )
    height = rng.uniform(-0.8, 0.5) * width / 3
    return sheet(vertices, faces, _paint(rng)).placed(np.eye(3), (0.0, 0.0, height))


def turtle(rng: np.random.Generator) -> Mesh:
    """A turtle or a seal: an oval body with limbs, mostly under water."""
    size = rng.uniform(0.5, 1.6)
    skin = np.array([0.05, 0.09, 0.10]) * rng.uniform(0.6, 4.0)
    x = size * np.array([-0.5, -0.35, 0.0, 0.35, 0.5])
    vertices, faces = tube(
        x, size * np.array([0.06, 0.2, 0.3, 0.2, 0.05]) * rng.uniform(0.4, 1.3),
        size * np.array([0.03, 0.1, 0.13, 0.1, 0.03]), sides=10,
    )  # fmt: skip
    parts = [sheet(vertices, faces, skin)]
    for _ in range(4):
        root = np.array([rng.choice([-0.3, 0.3]) * size, rng.choice([-0.2, 0.2]) * size, 0.0])
        out = np.array([rng.normal(0, 0.3), np.sign(root[1]) * 0.35, rng.normal(0, 0.05)]) * size
        side = np.array([0.07 * size, 0.0, 0.0])
        limb = [root - side, root + side, root + out]
        parts.append(sheet(limb, [(0, 1, 2)], skin * 0.8, two_sided=True))
    return join(parts).placed(np.eye(3), (0.0, 0.0, -rng.uniform(0.0, 0.6)))


def swimmer(rng: np.random.Generator) -> Mesh:
    """A person swimming or floating, arms and legs spread; some lie on a board."""
    skin = np.array(SKIN[int(rng.integers(len(SKIN)))]) * rng.uniform(0.8, 1.2)
    suit = _paint(rng) if rng.random() < 0.7 else skin
    size = rng.uniform(0.75, 1.1)
    body, body_faces = tube(
        size * np.array([-0.85, -0.45, -0.1, 0.25, 0.5]),
        size * np.array([0.06, 0.14, 0.17, 0.21, 0.10]),
        size * np.array([0.05, 0.08, 0.10, 0.11, 0.06]),
        sides=8,
    )
    head, head_faces = tube(
        size * np.array([0.5, 0.56, 0.68, 0.74]),
        size * np.array([0.05, 0.09, 0.09, 0.04]),
        size * np.array([0.05, 0.10, 0.10, 0.04]),
        sides=8,
    )
    cap = _paint(rng) if rng.random() < 0.4 else np.array(HAIR[int(rng.integers(len(HAIR)))])
    parts = [sheet(body, body_faces, suit), sheet(head, head_faces, cap)]
    for side in (-1.0, 1.0):
        stroke = rng.uniform(-1.2, 1.4)
        shoulder = size * np.array([0.35, side * 0.2, 0.02])
        hand = shoulder + 0.62 * size * np.array([np.sin(stroke), side * np.cos(stroke), 0.0])
        hand[2] += rng.normal(0.0, 0.12)
        kick = rng.uniform(0.0, 0.35)
        hip = size * np.array([-0.75, side * 0.08, 0.0])
        foot = hip + 0.75 * size * np.array([-np.cos(kick), side * np.sin(kick), 0.0])
        foot[2] -= rng.uniform(0.0, 0.3)
        parts += [_limb(shoulder, hand, 0.05 * size, skin), _limb(hip, foot, 0.06 * size, skin)]
    person = join(parts).placed(np.eye(3), (0.0, 0.0, -rng.uniform(-0.02, 0.25)))
    if rng.random() < 0.25:
        length, width = rng.uniform(1.8, 3.3), rng.uniform(0.25, 0.42)
        board, board_faces = tube(
            length * np.array([-0.5, -0.4, 0.0, 0.4, 0.5]),
            width * np.array([0.4, 0.8, 1.0, 0.7, 0.1]),
            np.full(5, 0.05),
            sides=8,
        )
        under = sheet(board, board_faces, _paint(rng))
        person = join([under, person.placed(np.eye(3), (0.0, 0.0, 0.3))])
    return person


def _limb(root: Array, end: Array, half_width: float, colour: Array) -> Mesh:
    """A flat strip from one point to another."""
    along = end - root
    across = np.array([-along[1], along[0], 0.0])
    across *= half_width / max(float(np.linalg.norm(across)), 1e-9)
    corners = [root - across, root + across, end + 0.7 * across, end - 0.7 * across]
    return sheet(corners, [(0, 1, 2), (0, 2, 3)], colour, two_sided=True)


Kinds = Mapping[str, Callable[[np.random.Generator], Mesh]]

PROPS: Kinds = {
    "buoy": buoy,
    "bird": bird,
    "weed": weed,
    "boat": boat,
    "plank": plank,
    "turtle": turtle,
    "swimmer": swimmer,
}


def random_prop(rng: np.random.Generator, east: float, north: float, kinds: Kinds = PROPS) -> Mesh:
    """One object of a random kind at a position on the surface, randomly turned."""
    names = sorted(kinds)
    mesh = kinds[names[int(rng.integers(len(names)))]](rng)
    yaw = rng.uniform(-np.pi, np.pi)
    c, s = np.cos(yaw), np.sin(yaw)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return mesh.placed(turn, (east, north, 0.0))


def _paint(rng: np.random.Generator) -> Array:
    colour = np.array(PAINT[int(rng.integers(len(PAINT)))])
    return np.clip(colour * rng.uniform(0.6, 1.2), 0.0, 0.85)
