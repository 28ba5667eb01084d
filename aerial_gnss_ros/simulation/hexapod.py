# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The rendered robot: an Aqua2-like hexapod, 0.65 x 0.45 x 0.13 m with its flippers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.simulation.mesh import Mesh, join, sheet, tube
from aerial_gnss_ros.simulation.scene import Colour

LENGTH = 0.65
"""m, hull from nose to tail."""
WIDTH = 0.45
"""m over the hips."""
HEIGHT = 0.13
"""m."""

Paint = tuple[Colour, Colour, Colour]
"""Hull, deck, stripe; reflectance blue, green, red."""

# Aqua robots exist in several liveries.
LIVERIES: dict[str, Paint] = {
    "yellow": ((0.03, 0.42, 0.72), (0.05, 0.05, 0.05), (0.03, 0.42, 0.72)),
    "orange": ((0.03, 0.16, 0.72), (0.06, 0.06, 0.06), (0.75, 0.75, 0.75)),
    "silver": ((0.50, 0.50, 0.48), (0.12, 0.12, 0.12), (0.50, 0.50, 0.48)),
    "red": ((0.04, 0.04, 0.55), (0.62, 0.62, 0.62), (0.04, 0.04, 0.55)),
    "white": ((0.74, 0.76, 0.76), (0.45, 0.25, 0.08), (0.74, 0.76, 0.76)),
    "black": ((0.035, 0.035, 0.035), (0.03, 0.40, 0.70), (0.6, 0.6, 0.6)),
}


@dataclass(frozen=True)
class RobotState:
    """Pose and look of one robot to render.

    Attributes:
        robot_id: Name in the truth, such as `aqua_1`.
        east, north: m, local ENU, of the hull's middle.
        course: Direction of the nose, yaw in ENU, rad.
        depth: m of the hull's middle below the mean water surface. At 0 half the hull stands out;
            -0.05 floats high, 0.3 is well submerged.
        speed: m/s over the water, for the wake.
        phase: Of the flippers' beat, rad.
        roll, pitch: rad, small.
        class_name: What a detector calls it.
        livery: Key of `LIVERIES`.
        paint: Hull, deck and stripe instead of the livery's, reflectance blue, green, red.
        model: Its shape, a name for `robot_models.robot_model`.
    """

    robot_id: str
    east: float
    north: float
    course: float
    depth: float = 0.0
    speed: float = 0.4
    phase: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    class_name: str = "aqua"
    livery: str = "yellow"
    paint: Paint | None = None
    model: str = "aqua"


def hexapod(phase: float, livery: str = "yellow", paint: Paint | None = None) -> Mesh:
    """The robot's mesh in its own frame (x forward, y left, z up, origin in the hull's middle).

    Args:
        phase: Of the flippers' beat, rad; neighbours beat in opposition as in a tripod gait.
        livery: Key of `LIVERIES`.
        paint: Instead of the livery's.
    """
    hull, deck, stripe = paint or LIVERIES[livery]
    parts = [_hull(hull), *_deck(deck, stripe)]
    for side in (-1.0, 1.0):
        for i, x in enumerate((0.225, 0.0, -0.225)):
            beat = phase + (np.pi if (i % 2 == 0) == (side > 0) else 0.0)
            parts += _leg(x, side, beat, hull)
    return join(parts)


def _hull(colour: Colour) -> Mesh:
    vertices, faces = tube(
        (-0.325, -0.305, -0.24, 0.22, 0.29, 0.325),
        (0.10, 0.135, 0.155, 0.155, 0.135, 0.085),
        (0.035, 0.055, HEIGHT / 2, HEIGHT / 2, 0.058, 0.035),
    )
    shade = np.tile(np.array(colour), (len(faces), 1))
    shade[vertices[faces].mean(axis=1)[:, 2] < -0.02] *= 0.5  # dark belly
    return sheet(vertices, faces, shade)


def _plate(x0: float, x1: float, y0: float, y1: float, z: float, colour: Colour) -> Mesh:
    corners = [(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)]
    return sheet(corners, [(0, 1, 2), (0, 2, 3)], colour, nearer=0.4)


def _deck(deck: Colour, stripe: Colour) -> list[Mesh]:
    top = HEIGHT / 2 + 0.002
    glass = (0.02, 0.02, 0.02)
    return [
        _plate(-0.21, -0.03, -0.105, 0.105, top, deck),
        _plate(0.03, 0.19, -0.105, 0.105, top, deck),
        _plate(-0.03, 0.03, -0.11, 0.11, top + 0.001, stripe),
        _plate(0.225, 0.275, -0.07, 0.07, top - 0.004, glass),
    ]


def _leg(x: float, side: float, beat: float, hull: Colour) -> list[Mesh]:
    """Hip and flipper: a soft plate that trails the hip and swings about the lateral axis."""
    y0 = side * 0.15
    hip_v, hip_f = tube((-0.03, 0.03), (0.022, 0.022), (0.03, 0.03), sides=6)
    hip_v = hip_v + np.array([x, y0 + side * 0.015, 0.0])
    swing = 0.55 * np.sin(beat)
    lag = 0.45 * np.sin(beat - 0.9)
    inner, outer = side * 0.155, side * (WIDTH / 2)
    splay = side * 0.035
    rows: list[NDArray[np.float64]] = []
    point = np.array([x + 0.03, 0.0])
    for i, angle in enumerate((swing, swing + 0.5 * lag, swing + lag)):
        rows.append(np.array([[point[0], inner, point[1]], [point[0], outer, point[1]]]))
        rows[-1][:, 1] += splay * i / 2.0
        point = point + 0.09 * np.array([-np.cos(angle), np.sin(angle)])
    rows.append(
        np.array([[point[0], inner + splay, point[1]], [point[0], outer + splay, point[1]]])
    )
    vertices = np.concatenate(rows)
    faces = [t for i in (0, 2, 4) for t in ((i, i + 1, i + 3), (i, i + 3, i + 2))]
    dark = tuple(0.055 + 0.12 * c for c in hull)
    return [
        sheet(hip_v, hip_f, (0.16, 0.16, 0.16)),
        sheet(vertices, faces, dark, two_sided=True),
    ]
