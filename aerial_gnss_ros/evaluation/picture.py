# SPDX-License-Identifier: Apache-2.0
"""Pictures of a result: map with tracks and ellipses, error over time."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.core.geodesy import enu_from_geodetic
from aerial_gnss_ros.core.values import Array
from aerial_gnss_ros.evaluation.errors import RobotErrors

# Okabe and Ito's colours: told apart by the colour-blind too.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442")
_CHI2_95_2D = 5.991


def map_png(
    estimates: Mapping[str, EstimatedTrack],
    truth: Mapping[str, Track],
    drone: Track | None = None,
) -> bytes:
    """Draw tracks, their last 95 % ellipses, truth and the drone's path; east to the right.

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
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    axes.grid(color="#dddddd")
    axes.set_axisbelow(True)
    latitude, longitude = np.degrees(origin)
    axes.set_xlabel(f"east of {longitude:.6f}° (m)")
    axes.set_ylabel(f"north of {latitude:.6f}° (m)")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="best", fontsize=9)
    return _png(figure)


def _draw_robot(
    axes: Any, name: str, track: EstimatedTrack, origin: tuple[float, float], colour: str
) -> None:
    east, north = _local(track, origin)
    shown = np.where(track.measured, 1.0, np.nan)
    axes.plot(east * shown, north * shown, color=colour, linewidth=2, label=name)
    axes.plot(east, north, color=colour, linewidth=1, linestyle=":")
    axes.plot(east[-1:], north[-1:], "o", color=colour, markersize=6)
    values, vectors = np.linalg.eigh(track.covariance[-1])
    width, height = 2.0 * np.sqrt(np.maximum(values[::-1], 0.0) * _CHI2_95_2D)
    angle = float(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
    axes.add_patch(
        Ellipse((east[-1], north[-1]), width, height, angle=angle, facecolor=colour, alpha=0.15)
    )
    axes.annotate(name, (east[-1], north[-1]), xytext=(8, 8), textcoords="offset points")


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
    return _png(figure)


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


def _png(figure: Figure) -> bytes:
    buffer = io.BytesIO()
    # Without the software entry the same figure gives the same bytes.
    figure.savefig(buffer, format="png", dpi=110, metadata={"Software": None})
    return buffer.getvalue()
