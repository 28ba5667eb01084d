# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Floating objects of random shape and colour.

A detector trained with ten kinds of distractors takes the eleventh for a robot. These belong to no
kind, so a detector must learn the appearance of robots (domain randomisation: Tobin et al. 2017).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.mesh import Mesh, join, sheet, tube
from aerial_gnss_ros.simulation.props import Kinds

Array = NDArray[np.float64]

_LONG_M = (0.15, 1.8)
_FLAT = np.eye(3)


def flotsam(rng: np.random.Generator) -> Mesh:
    """One to five simple bodies at random places beside one another, in one to three colours."""
    size = float(np.exp(rng.uniform(*np.log(_LONG_M))))
    colours = [random_colour(rng) for _ in range(int(rng.integers(1, 4)))]
    parts = []
    for number in range(1 + min(4, int(rng.geometric(0.45)) - 1)):
        body = _BODIES[int(rng.integers(len(_BODIES)))]
        share = rng.uniform(0.6, 1.0) if number == 0 else rng.uniform(0.15, 0.7)
        part = body(rng, size * share, colours[int(rng.integers(len(colours)))])
        place = np.zeros(2) if number == 0 else rng.normal(0.0, 0.3 * size, 2)
        parts.append(part.placed(_turn(rng.uniform(-np.pi, np.pi)), (*place, 0.0)))
    depth = abs(rng.normal(0.0, 0.25)) if rng.random() < 0.3 else rng.uniform(-0.05, 0.08) * size
    return join(parts).placed(_FLAT, (0.0, 0.0, -depth))


def random_colour(rng: np.random.Generator) -> Array:
    """A reflectance (3,) blue, green, red: grey or bright, as lacquer is, of 0.02 to 0.8."""
    value, grey = rng.uniform(0.02, 0.8), rng.random() < 0.4
    tint = np.ones(3) if grey else rng.uniform(0.03, 1.0, 3)
    colour: Array = np.clip(value * tint / tint.max(), 0.02, 0.8)
    return colour


def _bar(rng: np.random.Generator, long: float, colour: Array) -> Mesh:
    """A rod, a board, a box: of any section, with ends as wide or pointed."""
    wide = long * float(np.exp(rng.uniform(np.log(0.04), np.log(0.9))))
    high = min(wide, long * rng.uniform(0.03, 0.4))
    ends = rng.uniform(0.1, 1.0, 2)
    shares = np.array([ends[0], 1.0, 1.0, ends[1]])
    x = long * np.array([-0.5, rng.uniform(-0.48, -0.1), rng.uniform(0.1, 0.48), 0.5])
    sides = int(rng.choice([4, 6, 10]))
    vertices, faces = tube(x, 0.5 * wide * shares, 0.5 * high * shares, sides=sides)
    colours = np.tile(colour, (len(faces), 1))
    if rng.random() < 0.3:  # bands
        edges = np.floor(vertices[faces].mean(axis=1)[:, 0] * rng.uniform(3.0, 12.0) / long)
        colours[edges % 2 == 0] = random_colour(rng)
    return sheet(vertices, faces, colours)


def _ball(rng: np.random.Generator, long: float, colour: Array) -> Mesh:
    """An ellipsoid."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 7)[1:-1]
    wide, high = 0.5 * long * rng.uniform(0.3, 1.0, 2)
    x, across = 0.5 * long * np.sin(angle), np.cos(angle)
    vertices, faces = tube(x, wide * across, high * across, sides=10)
    return sheet(vertices, faces, colour)


def _ring(rng: np.random.Generator, long: float, colour: Array) -> Mesh:
    """A closed or open ring of straight rods."""
    count = int(rng.integers(5, 13))
    angle = 2.0 * np.pi * np.arange(count + 1) / count
    across = rng.uniform(0.4, 1.0)
    points = 0.5 * long * np.stack([np.cos(angle), across * np.sin(angle)], axis=-1)
    thick = long * rng.uniform(0.03, 0.12)
    other = random_colour(rng) if rng.random() < 0.4 else colour
    arcs = list(itertools.pairwise(points))[: count if rng.random() < 0.7 else count // 2]
    return join([_rod(a, b, thick, (colour, other)[i % 2]) for i, (a, b) in enumerate(arcs)])


def _blades(rng: np.random.Generator, long: float, colour: Array) -> Mesh:
    """Thin leaves in all directions."""
    parts = []
    for _ in range(int(rng.integers(1, 14))):
        turn = _turn(rng.uniform(-np.pi, np.pi))
        reach, wide = 0.5 * long * rng.uniform(0.4, 1.0), long * rng.uniform(0.02, 0.2)
        leaf = [(0.0, 0.0, 0.0), (reach / 2, wide / 2, 0.0), (reach, 0.0, 0.0),
                (reach / 2, -wide / 2, 0.0)]  # fmt: skip
        shade = np.clip(colour * rng.uniform(0.6, 1.4), 0.0, 0.85)
        part = sheet(leaf, [(0, 1, 2), (0, 2, 3)], shade, two_sided=True)
        root = (*rng.normal(0.0, 0.15 * long, 2), -abs(rng.normal(0.0, 0.05)))
        parts.append(part.placed(turn, root))
    return join(parts)


def _rod(start: Array, end: Array, thick: float, colour: Array) -> Mesh:
    along = end - start
    length = float(np.hypot(*along))
    vertices, faces = tube((0.0, length), (thick, thick), (thick, thick), sides=6)
    turn = _turn(float(np.arctan2(along[1], along[0])))
    return sheet(vertices, faces, colour).placed(turn, (*start, 0.0))


def _turn(yaw: float) -> Array:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


KINDS: Kinds = {"flotsam": flotsam}

_BODIES: tuple[Callable[[np.random.Generator, float, Array], Mesh], ...] = (
    _bar,
    _bar,
    _ball,
    _ring,
    _blades,
)
