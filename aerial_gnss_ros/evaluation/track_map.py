# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The map of a result: published tracks with ellipses, truth, the paths of drones."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Patch
from matplotlib.patheffects import withStroke

from aerial_gnss_ros.bags.drone_tables import DroneFlight
from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic
from aerial_gnss_ros.core.values.samples import Array
from aerial_gnss_ros.evaluation.picture import FAINT, GREY, colours, legend_above, north_arrow, png

_CHI2_95_2D = 5.991
_WIDE = 1.3
_LABEL_ORDER = 5
_ELLIPSES = 6
"""Number of ellipses along each track, from its first to its last position."""
_NAMED = 6
"""Greatest number of robots in the legend; all have their label on the map."""
_DRONE: dict[str, Any] = {"color": "#888888", "linewidth": 1.2, "marker": "^", "markersize": 8}
_SIGHT: dict[str, Any] = {"color": "#888888", "linewidth": 0.8, "linestyle": (0, (1, 3))}
_TRUTH: dict[str, Any] = {
    "color": "black", "linewidth": 1.2, "linestyle": "--", "marker": "x", "markersize": 8,
}  # fmt: skip
_COASTING: dict[str, Any] = {"linewidth": 1.0, "linestyle": ":"}
_TRACK: dict[str, Any] = {"linewidth": 2.0, "marker": "o", "markersize": 6}
Drones = Mapping[str, DroneFlight]
NO_DRONES: Drones = MappingProxyType({})


def map_png(
    estimates: Mapping[str, EstimatedTrack],
    truth: Mapping[str, Track],
    drone: Track | None = None,
    drones: Drones = NO_DRONES,
) -> bytes:
    """Draw `map_figure`.

    Returns:
        A PNG.
    """
    return png(map_figure(estimates, truth, drone, drones))


def map_figure(
    estimates: Mapping[str, EstimatedTrack],
    truth: Mapping[str, Track],
    drone: Track | None = None,
    drones: Drones = NO_DRONES,
) -> Figure:
    """Draw tracks with some of their 95 % ellipses, truth and the drones' paths; east to the right.

    Args:
        estimates: published tracks by robot id.
        truth: true tracks by id, may be empty.
        drone: the drone's own path, if known.
        drones: those of several drones with names, in place of it, and what each saw.
    """
    figure = Figure(figsize=(9, 7.4), layout="constrained")
    axes = figure.add_subplot()
    alone = [drone] if drone is not None and len(drone) and not drones else []
    paths = [*alone, *(one.path for one in drones.values())]
    origin = _origin([*estimates.values(), *truth.values(), *paths])
    for path in paths:
        axes.plot(*_local(path, origin), markevery=[-1], **_DRONE)
    middle = _middle(estimates, origin)
    for name, one in drones.items():
        _draw_sight(axes, name, one, estimates, origin, middle)
    shades = colours(estimates)
    for name, track in estimates.items():
        _draw_robot(axes, name, track, origin, shades[name], middle)
    for path in truth.values():
        axes.plot(*_local(path, origin), markevery=[-1], **_TRUTH)
    measured = [_local(_measured(track), origin) for track in estimates.values()]
    _frame(axes, [_local(path, origin) for path in [*truth.values(), *paths]] + measured)
    axes.set_aspect("equal", adjustable="box")
    axes.grid(color=FAINT)
    axes.set_axisbelow(True)
    north_arrow(axes)
    latitude, longitude = np.degrees(origin)
    axes.set_xlabel(f"east of longitude {longitude:.6f}° (m)")
    axes.set_ylabel(f"north of latitude {latitude:.6f}° (m)")
    legend_above(
        figure, _signs(estimates, shades, truth=bool(truth), drone=bool(paths), sight=bool(drones))
    )
    return figure


def _signs(
    estimates: Mapping[str, EstimatedTrack], shades: Mapping[str, str], *, truth: bool, drone: bool,
    sight: bool,
) -> list[Any]:  # fmt: skip
    """Return the legend's entries, drawn as on the map."""
    signs: list[Any] = [
        Line2D([], [], color=shades[name], label=name, **_TRACK)
        for name in estimates
        if len(estimates) <= _NAMED
    ]
    if estimates:
        signs.append(Patch(edgecolor=GREY, facecolor="none", label="95 % ellipse"))
        signs.append(Patch(color=GREY, alpha=0.25, label="last ellipse"))
    if any(not track.measured.all() for track in estimates.values()):
        signs.append(Line2D([], [], color=GREY, label="coasting (not seen)", **_COASTING))
    if truth:
        signs.append(Line2D([], [], label="truth (×: at the end)", **_TRUTH))
    if drone:
        signs.append(Line2D([], [], label="drone (▲: at the end)", **_DRONE))
    if sight:
        signs.append(Line2D([], [], label="in the drone's last image", **_SIGHT))
    return signs


def _draw_sight(
    axes: Any,
    name: str,
    drone: DroneFlight,
    estimates: Mapping[str, EstimatedTrack],
    origin: tuple[float, float],
    middle: Array,
) -> None:
    """Write a drone's name, and draw lines to the robots in its last image."""
    place = np.array(_local(drone.path, origin))[:, -1]
    for robot, stamps_ns in drone.seen.items():
        if robot in estimates and stamps_ns[-1] == drone.path.stamps_ns[-1]:
            track = estimates[robot]
            row = int(np.argmin(np.abs(track.stamps_ns - stamps_ns[-1])))
            end = np.array(_local(track, origin))[:, row]
            axes.plot(*np.stack([place, end], axis=1), **_SIGHT)
    _label(axes, name, place, middle, GREY)


def _draw_robot(
    axes: Any,
    name: str,
    track: EstimatedTrack,
    origin: tuple[float, float],
    colour: str,
    middle: Array,
) -> None:
    east, north = _local(track, origin)
    shown = np.where(track.measured, 1.0, np.nan)
    axes.plot(east, north, color=colour, **_COASTING)
    seen = np.flatnonzero(track.measured)
    if len(seen):
        axes.plot(east * shown, north * shown, color=colour, markevery=seen[-1:].tolist(), **_TRACK)
    else:
        seen = np.zeros(1, dtype=int)
    for row in np.unique(seen[np.linspace(0, len(seen) - 1, _ELLIPSES, dtype=int)]):
        axes.add_patch(_ellipse(track, int(row), (east[row], north[row]), colour, row == seen[-1]))
    _label(axes, name, np.array([east[seen[-1]], north[seen[-1]]]), middle, colour)


def _label(axes: Any, name: str, place: Array, middle: Array, colour: str) -> None:
    """Write a name beside a place, away from the middle of all robots, or names would overlap."""
    side = np.where(place >= middle, 1.0, -1.0)
    label = axes.annotate(
        name, tuple(place), xytext=tuple(9.0 * side), textcoords="offset points", color=colour,
        ha="left" if side[0] > 0.0 else "right", va="bottom" if side[1] > 0.0 else "top",
        fontweight="bold",
    )  # fmt: skip
    # Above all tracks, which would cross it.
    label.set(zorder=_LABEL_ORDER, path_effects=[withStroke(linewidth=3.0, foreground="white")])


def _middle(estimates: Mapping[str, EstimatedTrack], origin: tuple[float, float]) -> Array:
    """Return the mean of the robots' last measured positions (2,), m."""
    last = [
        np.array(_local(measured, origin))[:, -1]
        for measured in map(_measured, estimates.values())
        if len(measured)
    ]
    return np.mean(last, axis=0) if last else np.zeros(2)


def _frame(axes: Any, tracks: list[tuple[Array, Array]]) -> None:
    """Fit the axes to measured positions and truth: a coasting robot may leave the map."""
    east = np.concatenate([np.zeros(0), *(track[0] for track in tracks)])
    north = np.concatenate([np.zeros(0), *(track[1] for track in tracks)])
    if not len(east):  # no positions: not an error
        return
    half = 2.0 + 0.6 * max(np.ptp(north), np.ptp(east) / _WIDE)
    middle = 0.5 * (east.min() + east.max()), 0.5 * (north.min() + north.max())
    axes.set_xlim(middle[0] - _WIDE * half, middle[0] + _WIDE * half)
    axes.set_ylim(middle[1] - half, middle[1] + half)


def _ellipse(
    track: EstimatedTrack, row: int, center: tuple[float, float], colour: str, last: bool
) -> Ellipse:
    values, vectors = np.linalg.eigh(track.covariance[row])
    width, height = 2.0 * np.sqrt(np.maximum(values[::-1], 0.0) * _CHI2_95_2D)
    angle = float(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
    return Ellipse(
        center, width, height, angle=angle, facecolor=colour if last else "none",
        edgecolor=colour, alpha=0.2 if last else 0.4, linewidth=0.8,
    )  # fmt: skip


def _measured(track: EstimatedTrack) -> Track:
    seen = track.measured
    return Track(track.stamps_ns[seen], track.latitude[seen], track.longitude[seen])


def _origin(tracks: list[Track]) -> tuple[float, float]:
    for track in tracks:
        if len(track):
            return float(track.latitude[0]), float(track.longitude[0])
    return 0.0, 0.0


def _local(track: Track, origin: tuple[float, float]) -> tuple[Array, Array]:
    enu = enu_from_geodetic(
        track.latitude, track.longitude, np.zeros(len(track)), origin[0], origin[1], 0.0
    )
    return enu[:, 0], enu[:, 1]
