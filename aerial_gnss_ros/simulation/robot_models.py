# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Shapes of the rendered robots: hexapod, torpedo, box, catamaran, or from a file, in metres."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation import hexapod
from aerial_gnss_ros.simulation.hexapod import LIVERIES, Paint, RobotState
from aerial_gnss_ros.simulation.mesh import Mesh, block, join, sheet, tube
from aerial_gnss_ros.simulation.mesh_file import ENDINGS, read_mesh
from aerial_gnss_ros.text.sentences import shown

AQUA = "aqua"
"""The model that the shipped detector was trained on."""

_DARK = (0.03, 0.03, 0.03)
_GLASS = (0.02, 0.02, 0.02)


@dataclass(frozen=True)
class RobotModel:
    """One shape of robot.

    Attributes:
        name: of the model, and of its class in labels.
        length, width, height: over all, m.
        build: returns the mesh (x forward, y left, z up, origin in the middle of the hull at the
            waterline of depth 0) from the phase of its beat in rad and its paint.
    """

    name: str
    length: float
    width: float
    height: float
    build: Callable[[float, Paint], Mesh]

    @property
    def size(self) -> tuple[float, float, float]:
        """Length, width and height, m."""
        return self.length, self.width, self.height

    @property
    def scale(self) -> tuple[float, float]:
        """Length and width relative to those of the hexapod."""
        return self.length / hexapod.LENGTH, self.width / hexapod.WIDTH


def torpedo(_phase: float, paint: Paint) -> Mesh:
    """A torpedo-shaped AUV, 1.60 m long and 0.19 m thick, with four fins and a mast."""
    hull, deck, stripe = paint
    x = (-0.80, -0.78, -0.62, -0.45, 0.58, 0.68, 0.75, 0.79, 0.80)
    radii = (0.020, 0.035, 0.075, 0.095, 0.095, 0.085, 0.060, 0.030, 0.010)
    vertices, faces = tube(x, radii, radii, sides=14, roundness=1.0)
    middles = vertices[faces].mean(axis=1)[:, 0]
    shade = np.tile(np.array(hull), (len(faces), 1))
    shade[middles > 0.58] = deck
    shade[(middles < -0.45) & (middles > -0.62)] = stripe
    parts = [sheet(vertices, faces, shade)]
    for across, up in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
        corners = [(px, r * across, r * up) for px, r in
                   ((-0.74, 0.03), (-0.60, 0.07), (-0.64, 0.16), (-0.74, 0.16))]  # fmt: skip
        parts.append(sheet(corners, [(0, 1, 2), (0, 2, 3)], stripe, two_sided=True))
    parts.append(block((0.10, 0.16), (-0.012, 0.012), (0.09, 0.20), _DARK, nearer=0.3))
    return join(parts)


def box(_phase: float, paint: Paint) -> Mesh:
    """A box-shaped ROV, 0.457 x 0.338 x 0.254 m: two floats in an open frame, six thrusters."""
    hull, deck, stripe = paint
    parts = [
        block((-0.2285, 0.2285), (side - 0.008, side + 0.008), (-0.127, 0.080), deck)
        for side in (-0.161, 0.161)
    ]
    parts += [
        block((-0.19, 0.19), (-0.150, -0.035), (0.040, 0.127), hull),
        block((-0.19, 0.19), (0.035, 0.150), (0.040, 0.127), hull),
        block((-0.06, 0.00), (-0.035, 0.035), (0.060, 0.115), stripe, nearer=0.2),
        block((-0.20, 0.20), (-0.150, 0.150), (-0.127, -0.110), _DARK),
    ]
    vertices, faces = tube(
        (-0.17, -0.15, 0.15, 0.18, 0.20), (0.04, 0.057, 0.057, 0.045, 0.02),
        (0.04, 0.057, 0.057, 0.045, 0.02), sides=10, roundness=1.0,
    )  # fmt: skip
    shade = np.tile(np.array((0.55, 0.55, 0.55)), (len(faces), 1))
    shade[vertices[faces].mean(axis=1)[:, 0] > 0.15] = _GLASS
    parts.append(sheet(vertices - np.array([0.0, 0.0, 0.02]), faces, shade))
    parts += [_disc(px, py, 0.128, 0.034) for px in (-0.09, 0.09) for py in (-0.0925, 0.0925)]
    parts += [_disc(px, 0.0, 0.03, 0.03) for px in (-0.20, 0.20)]
    return join(parts)


def catamaran(_phase: float, paint: Paint) -> Mesh:
    """A small catamaran, 1.35 x 0.98 x 0.45 m: two hulls, two beams, a deck with a mast."""
    hull, deck, stripe = paint
    parts = []
    for side in (-0.38, 0.38):
        vertices, faces = tube(
            (-0.675, -0.66, -0.45, 0.25, 0.50, 0.62, 0.675),
            (0.06, 0.095, 0.110, 0.110, 0.080, 0.040, 0.010),
            (0.05, 0.080, 0.090, 0.090, 0.080, 0.060, 0.040),
        )
        shade = np.tile(np.array(hull), (len(faces), 1))
        shade[vertices[faces].mean(axis=1)[:, 0] > 0.50] = stripe
        parts.append(sheet(vertices + np.array([0.0, side, 0.02]), faces, shade))
    parts += [
        block((-0.36, -0.30), (-0.40, 0.40), (0.11, 0.15), _DARK),
        block((0.18, 0.24), (-0.40, 0.40), (0.11, 0.15), _DARK),
        block((-0.40, 0.28), (-0.20, 0.20), (0.14, 0.24), deck, nearer=0.5),
        block((-0.20, 0.08), (-0.11, 0.11), (0.24, 0.26), stripe, nearer=1.0),
        block((-0.30, -0.27), (-0.015, 0.015), (0.24, 0.38), _DARK, nearer=1.2),
    ]
    return join(parts)


def _disc(x: float, y: float, z: float, radius: float) -> Mesh:
    """A dark thruster, seen from above."""
    angle = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
    rim = [(x + radius * np.cos(a), y + radius * np.sin(a), z) for a in angle]
    faces = [(0, i, i + 1) for i in range(1, len(rim) - 1)]
    return sheet(rim, faces, _DARK, two_sided=True, nearer=0.3)


MODELS: dict[str, RobotModel] = {
    one.name: one
    for one in (
        RobotModel(
            AQUA,
            hexapod.LENGTH,
            hexapod.WIDTH,
            hexapod.HEIGHT,
            lambda phase, paint: hexapod.hexapod(phase, paint=paint),
        ),
        RobotModel("torpedo", 1.60, 0.32, 0.36, torpedo),
        RobotModel("box", 0.457, 0.338, 0.255, box),
        RobotModel("catamaran", 1.35, 0.98, 0.45, catamaran),
    )
}


def robot_model(name: str) -> RobotModel:
    """Return a model by its name, or from the mesh file of that path; its name is then the stem.

    Raises:
        ConfigError: there is none of this name, or the file has none.
    """
    if name.lower().endswith(ENDINGS):
        return _of_file(name)
    if name not in MODELS:
        raise ConfigError(
            f"there is no robot model {name!r}; choose one of {', '.join(MODELS)}, or give a mesh "
            f"file ({', '.join(ENDINGS)})."
        )
    return MODELS[name]


@lru_cache(maxsize=16)
def _of_file(name: str) -> RobotModel:
    mesh, coloured = read_mesh(Path(name))
    stem = Path(name).stem
    if not stem.replace("_", "").replace("-", "").isalnum() or stem in MODELS:
        raise ConfigError(
            f"the robot model {shown(name)} gives its class the name {shown(stem)}; rename the "
            "file to letters, digits, _ and -, and to no model of the simulation."
        )
    length, width, height = np.ptp(mesh.vertices, axis=0).tolist()

    def build(_phase: float, paint: Paint) -> Mesh:
        return replace(mesh, colours=np.where(coloured[:, None], mesh.colours, paint[0]))

    return RobotModel(stem, length, width, height, build)


def placed_robot(state: RobotState) -> Mesh:
    """The robot's mesh in local ENU with z = 0 on the mean water surface."""
    cr, sr = np.cos(state.roll), np.sin(state.roll)
    cp, sp = np.cos(state.pitch), np.sin(state.pitch)
    cy, sy = np.cos(state.course), np.sin(state.course)
    rx = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    rz = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    mesh = robot_model(state.model).build(state.phase, state.paint or LIVERIES[state.livery])
    return mesh.placed(rz @ ry @ rx, (state.east, state.north, -state.depth))
