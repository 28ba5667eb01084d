# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Shape and flipper poses of the robots: Aqua-like hexapods that differ in their proportions.

Frames: x forward, y left, z up, origin in the hull's middle, m and rad.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.blender.ranges import PAINTS, Paint, Ranges
from aerial_gnss_ros.simulation.hexapod import HEIGHT, LENGTH
from aerial_gnss_ros.simulation.mesh import Mesh, sheet, tube

Array = NDArray[np.float64]
SIDES = (1.0, -1.0)
ROWS = (1.0, 0.0, -1.0)
"""Hips from front to rear, in units of the hips' distance."""


@dataclass(frozen=True)
class Build:
    """Proportions of one robot."""

    length: float
    width: float
    height: float
    hips: float
    flipper_length: float
    flipper_width: float
    paint: Paint
    roughness: float
    marks: int
    handle: bool


@dataclass(frozen=True)
class FlipperPose:
    """Angles of one flipper: up-down about the hip, outward splay, bend of the outer half."""

    swing: float
    splay: float
    bend: float


@dataclass(frozen=True)
class Robot:
    """One robot as it is to be rendered.

    Attributes:
        robot_id: its name.
        build: its shape and paint.
        flippers: six poses, left and right of the front, middle and rear hips.
        east, north: of the hull's middle, local ENU, m.
        depth: of the hull's middle below the waves there, m.
        course, roll, pitch: rad, ENU and FLU.
        class_name: what a detector calls it.
        mesh: its shape if it is no hexapod; `build` and `flippers` then do not matter.
    """

    robot_id: str
    build: Build
    flippers: tuple[FlipperPose, ...]
    east: float
    north: float
    depth: float
    course: float
    roll: float
    pitch: float
    class_name: str = "aqua"
    mesh: Mesh | None = None


def random_build(rng: np.random.Generator, ranges: Ranges) -> Build:
    """Draw proportions within about 15 % of the fast renderer's robot, and a paint."""
    length = LENGTH * rng.uniform(0.88, 1.12)
    return Build(
        length=length,
        width=rng.uniform(0.21, 0.29),
        height=HEIGHT * rng.uniform(0.85, 1.2),
        hips=length * rng.uniform(0.33, 0.38),
        flipper_length=rng.uniform(0.16, 0.23),
        flipper_width=rng.uniform(0.065, 0.095),
        paint=PAINTS[str(rng.choice(ranges.paints))],
        roughness=rng.uniform(0.15, 0.6),
        marks=int(rng.integers(0, 4)),
        handle=bool(rng.random() < 0.5),
    )


def hull(build: Build) -> Mesh:
    """The flat body: nearly a box, tapered at nose and tail."""
    half = build.length / 2.0
    vertices, faces = tube(
        np.array([-1.0, -0.985, -0.93, -0.74, 0.70, 0.90, 0.98, 1.0]) * half,
        np.array([0.50, 0.76, 0.90, 1.0, 1.0, 0.86, 0.64, 0.48]) * build.width / 2.0,
        np.array([0.40, 0.62, 0.85, 1.0, 1.0, 0.84, 0.60, 0.40]) * build.height / 2.0,
        sides=20,
    )
    return sheet(vertices, faces, build.paint.hull)


def deck(build: Build) -> list[Mesh]:
    """Plates, windows and marks on the back, thin boxes."""
    top, half, wide = build.height / 2.0, build.length / 2.0, build.width / 2.0
    glass = (0.015, 0.012, 0.01)
    parts = [
        _box(
            (-0.62 * half, -0.12 * half), 0.66 * wide, (top - 0.01, top + 0.006), build.paint.deck
        ),
        _box((0.04 * half, 0.56 * half), 0.62 * wide, (top - 0.01, top + 0.005), build.paint.deck),
        _box((0.72 * half, 0.84 * half), 0.46 * wide, (0.7 * top, 0.97 * top), glass),
    ]
    for i in range(build.marks):
        x = (-0.5 + 0.42 * i) * half
        parts.append(_box((x, x + 0.12 * half), 0.4 * wide, (top, top + 0.009), build.paint.mark))
    if build.handle:
        parts.append(_box((-0.1 * half, 0.02 * half), 0.85 * wide, (top, top + 0.02), (0.02,) * 3))
    return parts


def hip(build: Build) -> Mesh:
    """The motor's housing at a flipper's root, its axis along y, about the origin."""
    vertices, faces = tube((-0.035, 0.035), (0.02, 0.02), (0.034, 0.034), sides=10)
    turned = vertices[:, [1, 0, 2]]
    return sheet(turned, faces[:, ::-1], tuple(0.5 * c + 0.03 for c in build.paint.flipper))


def flipper_halves(build: Build) -> tuple[Mesh, Mesh]:
    """Inner and outer half of a paddle that trails the hip (to -x), each from its joint."""
    half = build.flipper_length / 2.0
    wide = build.flipper_width / 2.0
    inner = _paddle((0.015, -0.3 * half, -0.65 * half, -half - 0.003), wide, (0.5, 0.6, 0.8, 0.95))
    outer = _paddle((0.003, -0.4 * half, -0.75 * half, -0.93 * half, -half), wide,
                    (0.95, 1.0, 0.9, 0.65, 0.3))  # fmt: skip
    colour = build.paint.flipper
    return sheet(*inner, colour), sheet(*outer, colour)


def _paddle(
    x: tuple[float, ...], wide: float, shares: tuple[float, ...]
) -> tuple[Array, NDArray[np.int64]]:
    order = np.argsort(x)
    thick = np.full(len(x), 0.004)
    return tube(np.array(x)[order], wide * np.array(shares)[order], thick, sides=8)


def _box(
    x: tuple[float, float], half_width: float, z: tuple[float, float], colour: tuple[float, ...]
) -> Mesh:
    corners = np.array([(a, b, c) for a in x for b in (-half_width, half_width) for c in z])
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
             (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]  # fmt: skip
    return sheet(corners, faces, colour)


def _tripod(rng: np.random.Generator) -> list[FlipperPose]:
    """Neighbours beat in opposition."""
    phase, size, splay = rng.uniform(0, 2 * np.pi), rng.uniform(0.25, 0.6), rng.uniform(0.1, 0.45)
    poses = []
    for i, side in ((i, side) for i in range(3) for side in SIDES):
        beat = phase + (np.pi if (i % 2 == 0) == (side > 0) else 0.0)
        bend = 0.8 * size * np.sin(beat - 0.9)
        poses.append(FlipperPose(size * np.sin(beat), splay, bend))
    return poses


def _hover(rng: np.random.Generator) -> list[FlipperPose]:
    """All flippers hang down and paddle a little."""
    down = rng.uniform(-1.5, -1.0)
    return [FlipperPose(down + rng.normal(0, 0.2), rng.uniform(0.0, 0.25), 0.1) for _ in range(6)]


def _glide(rng: np.random.Generator) -> list[FlipperPose]:
    """Trailing, nearly still."""
    splay = rng.uniform(0.15, 0.7)
    return [FlipperPose(rng.normal(0, 0.1), splay + rng.normal(0, 0.05), 0.0) for _ in range(6)]


def _turn(rng: np.random.Generator) -> list[FlipperPose]:
    """One side sweeps forward, the other trails."""
    forward = float(rng.choice(SIDES))
    return [
        FlipperPose(
            (np.pi if side == forward else 0.0) + rng.normal(0, 0.35), rng.uniform(0.3, 0.9), 0.3
        )
        for _ in ROWS
        for side in SIDES
    ]


def _brake(rng: np.random.Generator) -> list[FlipperPose]:
    """All forward and splayed."""
    return [
        FlipperPose(np.pi + rng.normal(0, 0.3), rng.uniform(0.4, 1.0), rng.normal(0, 0.2))
        for _ in range(6)
    ]


def _walk(rng: np.random.Generator) -> list[FlipperPose]:
    """Every flipper anywhere on its circle."""
    return [
        FlipperPose(rng.uniform(-np.pi, np.pi), rng.uniform(0.0, 0.6), rng.normal(0, 0.3))
        for _ in range(6)
    ]


GAITS: dict[str, Callable[[np.random.Generator], list[FlipperPose]]] = {
    "tripod": _tripod,
    "hover": _hover,
    "glide": _glide,
    "turn": _turn,
    "brake": _brake,
    "walk": _walk,
}


def random_flippers(rng: np.random.Generator, ranges: Ranges) -> tuple[FlipperPose, ...]:
    """Six poses of one of the gaits."""
    return tuple(GAITS[str(rng.choice(ranges.gaits))](rng))
