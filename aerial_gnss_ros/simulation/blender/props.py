# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Distractors of other shapes than those of `simulation.props`."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np

from aerial_gnss_ros.simulation.mesh import Mesh, join, sheet, tube
from aerial_gnss_ros.simulation.props import PAINT

_UPRIGHT = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])


def swimmer(rng: np.random.Generator) -> Mesh:
    """A person on the back or the front: head, trunk, arms, legs, bathing clothes."""
    skin = np.array([0.16, 0.25, 0.42]) * rng.uniform(0.35, 1.3)
    parts = [
        _limb((0.62, 0.0), (0.86, 0.0), 0.10, 0.09, _cap(rng, skin)),
        _limb((-0.05, 0.0), (0.58, 0.0), 0.20, 0.12, skin),
        _limb((-0.18, 0.0), (0.12, 0.0), 0.19, 0.125, _paint(rng)),
    ]
    for side in (-1.0, 1.0):
        spread = rng.uniform(0.05, 0.35)
        parts.append(_limb((-0.1, side * 0.09), (-0.9, side * (0.09 + spread)), 0.07, 0.06, skin))
        angle = rng.uniform(-1.2, 2.6)
        elbow = (0.5 + 0.55 * np.sin(angle), side * (0.2 + 0.55 * abs(np.cos(angle))))
        parts.append(_limb((0.5, side * 0.2), elbow, 0.05, 0.045, skin))
    return join(parts).placed(np.eye(3), (0.0, 0.0, rng.uniform(-0.2, 0.02)))


def paddle_board(rng: np.random.Generator) -> Mesh:
    """A board or a surf ski, sometimes with somebody lying on it."""
    length, width = rng.uniform(2.0, 3.6), rng.uniform(0.45, 0.85)
    x = length * np.array([-0.5, -0.45, -0.2, 0.2, 0.42, 0.5])
    vertices, faces = tube(x, width / 2 * np.array([0.35, 0.7, 1.0, 0.95, 0.5, 0.06]),
                           np.full(6, 0.06), sides=12)  # fmt: skip
    parts = [sheet(vertices, faces, _paint(rng))]
    if rng.random() < 0.5:
        parts.append(swimmer(rng).placed(np.eye(3), (0.0, 0.0, 0.25)))
    return join(parts)


def ring(rng: np.random.Generator) -> Mesh:
    """A lifebuoy or a tyre: eight short tubes in a circle."""
    radius, thick = rng.uniform(0.25, 0.6), rng.uniform(0.05, 0.11)
    one, other = _paint(rng), _paint(rng)
    corners = 2 * np.pi * np.arange(13) / 12
    points = radius * np.stack([np.cos(corners), np.sin(corners)], axis=-1)
    return join(
        [
            _limb(tuple(a), tuple(b), thick, thick, one if i % 3 else other)
            for i, (a, b) in enumerate(itertools.pairwise(points))
        ]
    )


def channel_mark(rng: np.random.Generator) -> Mesh:
    """A can or a cone on a disc, 0.5 to 1.5 m wide, 1 to 3 m high."""
    radius, high = rng.uniform(0.25, 0.75), rng.uniform(0.8, 2.4)
    top = radius * rng.choice([0.15, 0.7])
    disc, disc_faces = tube((-0.3, 0.15), (radius, radius), (radius, radius), sides=14)
    body, body_faces = tube(
        (0.15, 0.2, high), (radius * 0.8, radius * 0.7, top), (radius * 0.8, radius * 0.7, top)
    )
    colour = _paint(rng)
    return join(
        [sheet(disc @ _UPRIGHT.T, disc_faces, colour), sheet(body @ _UPRIGHT.T, body_faces, colour)]
    )


def crate(rng: np.random.Generator) -> Mesh:
    """A fish box or a jerrycan of a robot's size, with ribs instead of flippers."""
    length, width, high = rng.uniform(0.4, 0.8), rng.uniform(0.25, 0.5), rng.uniform(0.1, 0.3)
    colour = _paint(rng)
    vertices, faces = tube((-length / 2, length / 2), (width / 2,) * 2, (high / 2,) * 2, sides=8)
    parts = [sheet(vertices, faces, colour)]
    for x in np.linspace(-0.4, 0.4, int(rng.integers(2, 5))) * length:
        rib, rib_faces = tube((x, x + 0.03), (0.53 * width,) * 2, (0.53 * high,) * 2, sides=8)
        parts.append(sheet(rib, rib_faces, 0.7 * colour))
    return join(parts).placed(np.eye(3), (0.0, 0.0, rng.uniform(-0.4, 0.3) * high))


def trunk(rng: np.random.Generator) -> Mesh:
    """A log with a few branches."""
    bark = np.array([0.05, 0.09, 0.13]) * rng.uniform(0.4, 1.6)
    length, thick = rng.uniform(0.6, 3.5), rng.uniform(0.05, 0.18)
    parts = [_limb((-length / 2, 0.0), (length / 2, 0.0), thick, thick, bark)]
    for _ in range(int(rng.integers(0, 6))):
        x, reach = rng.uniform(-0.5, 0.5) * length, rng.uniform(0.15, 0.6)
        angle = rng.choice([-1.0, 1.0]) * rng.uniform(0.4, 1.3)
        tip = (x + reach * np.cos(angle), reach * np.sin(angle))
        parts.append(_limb((x, 0.0), tip, 0.3 * thick, 0.3 * thick, bark))
    return join(parts).placed(np.eye(3), (0.0, 0.0, rng.uniform(-1.0, 0.3) * thick))


def leaves(rng: np.random.Generator) -> Mesh:
    """A raft of kelp: long thin blades in all directions."""
    green = np.array([0.02, 0.10, 0.08]) * rng.uniform(0.5, 2.0)
    parts = []
    for _ in range(int(rng.integers(10, 40))):
        root, turn = rng.normal(0.0, 0.25, 2), rng.normal(0.0, 0.8)
        length, wide = rng.uniform(0.2, 0.9), rng.uniform(0.015, 0.05)
        along, across = (
            np.array([np.cos(turn), np.sin(turn)]),
            np.array([-np.sin(turn), np.cos(turn)]),
        )
        z = -abs(rng.normal(0.0, 0.08))
        corners = [root, root + length * 0.5 * along + wide * across, root + length * along,
                   root + length * 0.5 * along - wide * across]  # fmt: skip
        blade = np.column_stack([corners, np.full(4, z)])
        parts.append(
            sheet(blade, [(0, 1, 2), (0, 2, 3)], green * rng.uniform(0.6, 1.4), two_sided=True)
        )
    return join(parts)


def _limb(
    start: tuple[float, ...], end: tuple[float, ...], wide: float, high: float, colour: np.ndarray
) -> Mesh:
    """A rounded tube from one point of the surface to another."""
    a, b = np.array(start), np.array(end)
    length = float(np.hypot(*(b - a)))
    shares = np.array([0.4, 0.85, 1.0, 0.85, 0.4])
    x = length * np.array([0.0, 0.1, 0.5, 0.9, 1.0])
    vertices, faces = tube(x, wide * shares, high * shares, sides=10)
    c, s = (b - a) / max(length, 1e-9)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return sheet(vertices, faces, colour).placed(turn, (*a, 0.0))


def _paint(rng: np.random.Generator) -> np.ndarray:
    return np.clip(np.array(PAINT[int(rng.integers(len(PAINT)))]) * rng.uniform(0.6, 1.2), 0, 0.85)


def _cap(rng: np.random.Generator, skin: np.ndarray) -> np.ndarray:
    hair = np.array([0.02, 0.03, 0.04]) * rng.uniform(0.5, 4.0)
    return _paint(rng) if rng.random() < 0.4 else 0.3 * skin + hair


HARBOUR: dict[str, Callable[[np.random.Generator], Mesh]] = {
    "swimmer": swimmer,
    "paddle_board": paddle_board,
    "ring": ring,
    "channel_mark": channel_mark,
    "crate": crate,
    "trunk": trunk,
    "leaves": leaves,
}
