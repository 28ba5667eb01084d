# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Composites drawn bodies over the sea, and measures their contrast."""

from __future__ import annotations

from dataclasses import dataclass

import cv2

from aerial_gnss_ros.simulation.hexapod import RobotState
from aerial_gnss_ros.simulation.mesh import Mesh
from aerial_gnss_ros.simulation.planes import F32, U8
from aerial_gnss_ros.simulation.raster import Layer
from aerial_gnss_ros.simulation.view import Window


@dataclass
class Body:
    """A drawn body: a robot (with state) or a prop (without)."""

    mesh: Mesh
    state: RobotState | None
    layer: Layer
    visible: F32
    distance: float


def slices(inner: Window, outer: Window) -> tuple[slice, slice]:
    """Rows and columns of `inner` in an array that covers `outer`."""
    y, x = inner.y - outer.y, inner.x - outer.x
    return slice(y, y + inner.height), slice(x, x + inner.width)


def paint_above(planes: list[F32], layer: Layer, area: Window) -> None:
    """Composites the parts above water over planes of light that cover `area`."""
    overlap = layer.window.clipped(area)
    if overlap is None:
        return
    source, target = layer.above[slices(overlap, layer.window)], slices(overlap, area)
    for i, plane in enumerate(planes):
        plane[target] = plane[target] * (1.0 - source[..., 3]) + source[..., i]


def paint_below(glow: list[F32], layer: Layer, area: Window) -> None:
    """Composites parts under water into the water's glow; deep ones hide less (Beer-Lambert)."""
    overlap = layer.window.clipped(area)
    if overlap is None:
        return
    source, target = slices(overlap, layer.window), slices(overlap, area)
    for i, plane in enumerate(glow):
        plane[target] *= 1.0 - layer.hidden[source][..., i]
        plane[target] += layer.below[source][..., i]


def contrasts(bodies: list[Body], area: Window, clean: U8, dirty: U8) -> dict[str, float]:
    """Contrast of each robot in an area, given without (clean) and with robots, by robot_id."""
    result = {}
    change = cv2.absdiff(clean, dirty).mean(axis=-1) / 255.0
    for body in bodies:
        overlap = body.layer.window.clipped(area)
        if body.state is None or overlap is None:
            continue
        weight = body.visible[slices(overlap, body.layer.window)]
        total = float(weight.sum())
        value = float((change[slices(overlap, area)] * weight).sum()) / total if total > 0 else 0.0
        result[body.state.robot_id] = value
    return result


def merged(windows: list[Window]) -> list[Window]:
    """Unites overlapping windows until all are disjoint."""
    done: list[Window] = []
    for window in windows:
        grown = window
        while True:
            other = next((w for w in done if grown.clipped(w) is not None), None)
            if other is None:
                break
            done.remove(other)
            grown = grown.united(other)
        done.append(grown)
    return done
