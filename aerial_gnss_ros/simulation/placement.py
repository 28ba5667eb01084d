# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Chooses positions of robots on the water that the camera sees."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.simulation.flight import NADIR_TILT, Flight, Motion
from aerial_gnss_ros.simulation.hexapod import LENGTH

Array = NDArray[np.float64]

MOMENTS = 24
"""Number of times in the flight at which the view is sampled."""
PER_MOMENT = 60
MARGIN = 0.1
"""Share of the image at each edge that does not count as in view: robots move and have a size."""
LEAST_LONG_PX = (24.0, 12.0, 6.0, 2.0)
"""Least lengths of a robot in the image, px, tried in order."""


def place_robots(
    flight: Flight,
    camera: CameraModel,
    count: int,
    rng: np.random.Generator,
    apart_m: float = 2.5,
    others: Sequence[Flight] = (),
) -> Array:
    """Return positions (count, 2) East, North in m that the camera sees most of the flight.

    If it looks straight down throughout, the first is below the middle of the drone's path.

    Args:
        flight: true motion of the camera.
        camera: lens and image size.
        count: how many.
        rng: where the chance comes from.
        apart_m: least distance between two, m; less if there is no room.
        others: flights of like cameras that are to see them, too.

    Raises:
        InputError: the camera never sees water close enough.
    """
    if count == 0:
        return np.zeros((0, 2))
    places, shares = seen_places(flight, camera, rng)
    reach = float(camera.K[0, 0]) * LENGTH / LEAST_LONG_PX[-1]
    for other in others:
        shares = np.minimum(shares, seen_share(_moments(other), camera, places, reach))
    return _spread(places, shares, count, apart_m, rng, _below(_moments(flight)))


def seen_places(
    flight: Flight, camera: CameraModel, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return random positions (n, 2) on the water in view, and their shares (n,).

    A share is that of the sampled times at which the position is well inside the image.

    Raises:
        InputError: the camera never sees water close enough.
    """
    motion = _moments(flight)
    for long_px in LEAST_LONG_PX:
        reach = float(camera.K[0, 0]) * LENGTH / long_px
        places = _seen_water(motion, camera, reach, rng)
        if len(places):
            return places, seen_share(motion, camera, places, reach)
    raise InputError(
        f"the camera sees no water within {reach:.0f} m during this flight (beyond, a robot has "
        "no pixels); let it look down, choose another part with --start, or give --robot-at."
    )


def view_width(flight: Flight, camera: CameraModel) -> float:
    """Return the width of water across the image centre, m: the median over the flight.

    If the centre is above the horizon, the camera's height replaces its distance.
    """
    motion = _moments(flight)
    height, down = motion.camera[:, 2], -motion.enu_from_camera[:, 2, 0]
    distance = np.where(down > 0.1, height / np.maximum(down, 0.1), height)
    return float(np.median(distance)) * camera.width / float(camera.K[0, 0])


def seen_share(motion: Motion, camera: CameraModel, places: Array, reach_m: float) -> Array:
    """Return the share (n,) of times at which positions (n, 2) are well inside the image."""
    points = np.column_stack([places, np.zeros(len(places))])
    inset = MARGIN * np.array([camera.width, camera.height])
    limit = np.array([camera.width, camera.height]) - inset
    seen = np.zeros(len(places))
    for position, rotation in zip(motion.camera, motion.enu_from_camera, strict=True):
        offset = points - position
        pixels, valid = camera.project(offset @ (rotation @ FLU_FROM_OPTICAL))
        with np.errstate(invalid="ignore"):
            inside = ((pixels > inset) & (pixels < limit)).all(axis=1)
        seen += valid & inside & (np.linalg.norm(offset, axis=1) < reach_m)
    return np.asarray(seen / len(motion.t))


def _seen_water(
    motion: Motion, camera: CameraModel, reach_m: float, rng: np.random.Generator
) -> Array:
    """Return points (n, 2) on the water at random pixels of the inner image at each time."""
    size = np.array([camera.width, camera.height])
    found = []
    for position, rotation in zip(motion.camera, motion.enu_from_camera, strict=True):
        pixels = size * rng.uniform(MARGIN, 1.0 - MARGIN, (PER_MOMENT, 2))
        rays, valid = camera.rays(pixels)
        world = rays @ (rotation @ FLU_FROM_OPTICAL).T
        down = np.where(valid & (world[:, 2] < -1e-6), world[:, 2], -1e-9)
        ranges = -position[2] / down
        near = (ranges < reach_m) & (ranges > 0.5)
        found.append((position + ranges[:, None] * world)[near, :2])
    return np.concatenate(found)


def _moments(flight: Flight) -> Motion:
    return flight.sample(np.linspace(0.0, flight.duration_s, MOMENTS))


def _below(motion: Motion) -> list[Array]:
    """Return the point below the middle of the drone's path if the camera looks straight down."""
    steepness = -motion.enu_from_camera[:, 2, 0]
    if steepness.min() < math.sin(NADIR_TILT):
        return []
    return [np.median(motion.camera[:, :2], axis=0)]


def _spread(
    places: Array,
    shares: Array,
    count: int,
    spacing: float,
    rng: np.random.Generator,
    first: list[Array],
) -> Array:
    """Choose random positions among the most visible, apart from one another and the first."""
    good = places[shares >= 0.9 * shares.max()]
    order = rng.permutation(len(good))
    chosen = list(first)
    while len(chosen) < count:
        for place in good[order]:
            if all(math.dist(place, other) >= spacing for other in chosen):
                chosen.append(place)
            if len(chosen) == count:
                break
        else:
            spacing *= 0.7
            if spacing < 1e-3:  # more robots than positions: they share them
                chosen.append(good[order[len(chosen) % len(good)]] + rng.normal(0.0, 0.3, 2))
    return np.array(chosen)
