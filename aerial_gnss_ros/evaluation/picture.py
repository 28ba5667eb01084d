# SPDX-License-Identifier: Apache-2.0
"""Pictures of a result: map with tracks and ellipses, error over time."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from matplotlib.patheffects import withStroke

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.core.geodesy import enu_from_geodetic
from aerial_gnss_ros.core.values import Array
from aerial_gnss_ros.evaluation.errors import RobotErrors

# Okabe and Ito's colours: told apart by the colour-blind too.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442")
_CHI2_95_2D = 5.991
_WIDE = 1.3
_LABEL_ORDER = 5
_ELLIPSES = 6
"""So many along each track, from its first position to its last."""


def map_png(
    estimates: Mapping[str, EstimatedTrack],
    truth: Mapping[str, Track],
    drone: Track | None = None,
) -> bytes:
    """Draw tracks with some of their 95 % ellipses, truth and the drone's path; east to the right.

    Args:
        estimates: published tracks by robot id.
        truth: true tracks by id, may be empty.
        drone: the drone's own path, if known.

    Returns:
        A PNG.
    """
    figure = Figure(figsize=(9, 7), layout="constrained")
    axes = figure.add_subplot()
    origin = _origin([*estimates.values(), *truth.values(), *([drone] if drone else [])])
    if drone is not None and len(drone):
        east, north = _local(drone, origin)
        axes.plot(east, north, color="#999999", linewidth=1, label="drone")
        axes.plot(east[-1:], north[-1:], marker="^", color="#555555", markersize=9)
    for index, (name, track) in enumerate(estimates.items()):
        _draw_robot(axes, name, track, origin, COLOURS[index % len(COLOURS)])
    for index, true_track in enumerate(truth.values()):
        east, north = _local(true_track, origin)
        label = "truth" if index == 0 else None
        axes.plot(east, north, "k--", linewidth=1.2, label=label)
        axes.plot(east[-1:], north[-1:], "kx", markersize=8)
    shown = [*truth.values(), *([drone] if drone is not None and len(drone) else [])]
    _frame(
        axes,
        [_local(t, origin) for t in shown]
        + [_local(_measured(t), origin) for t in estimates.values()],
    )
    axes.set_aspect("equal", adjustable="box")
    axes.grid(color="#dddddd")
    axes.set_axisbelow(True)
    latitude, longitude = np.degrees(origin)
    axes.set_xlabel(f"east of {longitude:.6f}° (m)")
    axes.set_ylabel(f"north of {latitude:.6f}° (m)")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="best", fontsize=9)
    return png(figure)


def _draw_robot(
    axes: Any, name: str, track: EstimatedTrack, origin: tuple[float, float], colour: str
) -> None:
    east, north = _local(track, origin)
    shown = np.where(track.measured, 1.0, np.nan)
    axes.plot(east * shown, north * shown, color=colour, linewidth=2, label=name)
    axes.plot(east, north, color=colour, linewidth=1, linestyle=":")
    axes.plot(east[-1:], north[-1:], "o", color=colour, markersize=6)
    seen = np.flatnonzero(track.measured)
    if not len(seen):
        seen = np.zeros(1, dtype=int)
    for row in np.unique(seen[np.linspace(0, len(seen) - 1, _ELLIPSES, dtype=int)]):
        axes.add_patch(_ellipse(track, int(row), (east[row], north[row]), colour, row == seen[-1]))
    place = (east[seen[-1]], north[seen[-1]])
    label = axes.annotate(name, place, xytext=(8, 8), textcoords="offset points", color=colour)
    # Above all tracks, or these cross it out.
    label.set(zorder=_LABEL_ORDER, path_effects=[withStroke(linewidth=3.0, foreground="white")])


def _frame(axes: Any, tracks: list[tuple[Array, Array]]) -> None:
    """Show what was measured or is true: a robot that coasts away may leave the map."""
    east = np.concatenate([np.zeros(0), *(track[0] for track in tracks)])
    north = np.concatenate([np.zeros(0), *(track[1] for track in tracks)])
    if not len(east):  # nothing was found: no reason to fail
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
        edgecolor=colour, alpha=0.15 if last else 0.35, linewidth=0.8,
    )  # fmt: skip


def error_png(methods: Mapping[str, list[RobotErrors]]) -> bytes:
    """Draw the horizontal error over time, one panel a method.

    Returns:
        A PNG.
    """
    figure = Figure(figsize=(9, 1.0 + 2.2 * max(len(methods), 1)), layout="constrained")
    panels = figure.subplots(max(len(methods), 1), 1, sharex=True, sharey=True, squeeze=False)
    starts = [r.stamps_ns[0] for robots in methods.values() for r in robots if len(r.stamps_ns)]
    start = min(starts, default=0)
    for axes, (method, robots) in zip(panels[:, 0], methods.items(), strict=False):
        for index, robot in enumerate(robots):
            seconds = (robot.stamps_ns - start) * 1e-9
            axes.plot(
                seconds, robot.distance, ".", markersize=3, color=COLOURS[index % len(COLOURS)],
                label=robot.truth_id,
            )  # fmt: skip
        axes.set_ylabel("error (m)")
        axes.set_title(method, loc="left", fontsize=10)
        axes.set_ylim(bottom=0.0)
        axes.grid(color="#dddddd")
    panels[-1, 0].set_xlabel("time (s)")
    if starts:
        panels[0, 0].legend(loc="upper right", fontsize=8)
    return png(figure)


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


def png(figure: Figure) -> bytes:
    """Return a figure as PNG."""
    buffer = io.BytesIO()
    # Without the software entry the same figure gives the same bytes.
    figure.savefig(buffer, format="png", dpi=110, metadata={"Software": None})
    return buffer.getvalue()
