# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Places floating objects in view, clear of the robots' paths and of one another."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.simulation.flight import Flight
from aerial_gnss_ros.simulation.mesh import Mesh
from aerial_gnss_ros.simulation.placement import seen_places
from aerial_gnss_ros.simulation.props import random_prop

Array = NDArray[np.float64]

ROBOT_M = 0.65
"""Least distance between a robot's centre and any other object, m; flippers reach 0.54 m, see also
`_GRID_M`."""
APART_M = 0.2
"""Least gap between two objects, m."""
LEAST_SHARE = 0.3
"""Least visibility of a position, as a share of that of the best one."""
_GRID_M = 0.1
"""Grid to which paths are rounded, m, so that positions are not tested twice."""


def place_things(
    flight: Flight,
    camera: CameraModel,
    count: int,
    paths: Array,
    rng: np.random.Generator,
    robot_m: float = ROBOT_M,
) -> tuple[Mesh, ...]:
    """Return floating objects, fewer than requested if there is no room.

    Each is drawn once: one without room is left out, not replaced by a smaller one.

    Args:
        flight: true motion of the camera.
        camera: lens and image size.
        count: number of objects.
        paths: (n, 2) East, North of all robots at all times, m.
        rng: random numbers.
        robot_m: least distance from a robot's centre, m.

    Raises:
        InputError: the camera never sees water close enough.
    """
    if count == 0:
        return ()
    places, shares = seen_places(flight, camera, rng)
    swum = np.unique(np.round(paths / _GRID_M), axis=0) * _GRID_M
    places = places[shares >= LEAST_SHARE * shares.max()]
    places = places[[np.hypot(*(swum - p).T).min(initial=np.inf) >= robot_m for p in places]]
    things: list[Mesh] = []
    for _ in range(count):
        thing = random_prop(rng, 0.0, 0.0)
        shape, others = outline(thing), [outline(other) for other in things]
        for place in rng.permutation(places):
            here = shape + place
            if all(apart(here, other) >= APART_M for other in others) and (
                gaps(here, swum).min(initial=np.inf) >= robot_m
            ):
                things.append(thing.placed(np.eye(3), (*place, 0.0)))
                places = places[gaps(here, places) >= APART_M]
                break
    return tuple(things)


def outline(thing: Mesh) -> Array:
    """Return the convex outline (n, 2) of an object from above, counter-clockwise."""
    hull = cv2.convexHull(thing.vertices[:, :2].astype(np.float32), clockwise=False)
    return np.asarray(hull.reshape(-1, 2), dtype=np.float64)


def gaps(shape: Array, points: Array) -> Array:
    """Return how far points (n, 2) are outside an outline, m (n,); negative within.

    It is at most the true distance, and less near corners: see `_beyond`.
    """
    return np.asarray(_beyond(shape, points).max(axis=1))


def apart(one: Array, other: Array) -> float:
    """Return the gap between two outlines, m: at most the true one, negative where they overlap.

    Two convex outlines that do not overlap are separated by the line through a side of one of them
    (separating axis theorem).
    """
    lines = (_beyond(one, other), _beyond(other, one))
    return float(max(beyond.min(axis=0).max() for beyond in lines))


def _beyond(shape: Array, points: Array) -> Array:
    """Return how far points (n, 2) lie outside the lines through an outline's sides, m (n, m)."""
    sides = np.roll(shape, -1, axis=0) - shape
    normals = np.column_stack([sides[:, 1], -sides[:, 0]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(points @ normals.T - (shape * normals).sum(axis=1))
