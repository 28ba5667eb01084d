# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The paper's figures: error over frames, latitude and longitude error; and error against others.

Colours follow the truth's names, so a robot has one colour in all figures.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.samples import Array
from aerial_gnss_ros.evaluation.errors import RobotErrors
from aerial_gnss_ros.evaluation.picture import FAINT, GREY, INK, legend_above, png, utc_axis
from aerial_gnss_ros.evaluation.unseen import Unseen

Shades = Mapping[str, str]
_BINS = 8
_LEAST_IN_BIN = 5
_SIDE_BY_SIDE = 4
"""More methods than this are drawn in two columns."""


def _frames(robots: Sequence[RobotErrors]) -> NDArray[np.int64]:
    """Return the stamps of all compared images; a stamp's index is its frame."""
    stamps = [robot.stamps_ns for robot in robots]
    return np.unique(np.concatenate(stamps)) if stamps else np.zeros(0, dtype=np.int64)


def _label(robot: RobotErrors) -> str:
    other = robot.robot_id
    return robot.truth_id if other == robot.truth_id else f"{robot.truth_id}, published as {other}"


def _broken(frames: NDArray[np.signedinteger[Any]], values: Array) -> tuple[Array, Array]:
    """Return a line interrupted at missing frames."""
    gaps = np.flatnonzero(np.diff(frames) > 5) + 1
    return np.insert(frames.astype(float), gaps, np.nan), np.insert(values, gaps, np.nan)


def _found(robots: Sequence[RobotErrors]) -> Iterator[RobotErrors]:
    return (robot for robot in robots if len(robot.stamps_ns))


def _names(robots: Sequence[RobotErrors], shades: Shades, **style: Any) -> list[Any]:
    """Return the legend entries of tracked robots."""
    return [
        Line2D([], [], color=shades[r.truth_id], label=_label(r), **style) for r in _found(robots)
    ]


def frames_png(robots: Sequence[RobotErrors], shades: Shades) -> bytes:
    """Draw the haversine error over frames, one line per robot, as in the paper."""
    figure = Figure(figsize=(9, 3.8), layout="constrained")
    axes = figure.add_subplot()
    stamps = _frames(robots)
    for robot in _found(robots):
        colour = shades[robot.truth_id]
        frames, values = _broken(np.searchsorted(stamps, robot.stamps_ns), robot.haversine)
        axes.plot(frames, values, color=colour, linewidth=1.2)
        axes.axhline(float(np.mean(robot.haversine)), color=colour, linewidth=0.9, linestyle=":")
    axes.set_xlabel("frame")
    axes.set_ylabel("haversine error (m)")
    axes.set_ylim(bottom=0.0)
    axes.grid(color=FAINT)
    mean = Line2D([], [], color=GREY, linewidth=0.9, linestyle=":", label="mean of each")
    legend_above(figure, [*_names(robots, shades), mean])
    return png(figure)


def axes_png(robots: Sequence[RobotErrors], shades: Shades) -> bytes:
    """Draw latitude and longitude error over frames in metres, within lines of two sigma."""
    figure = Figure(figsize=(9, 5.4), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True, sharey=True)
    stamps = _frames(robots)
    for axis, (axes, title) in enumerate(zip(panels, ("latitude", "longitude"), strict=True)):
        column = 1 - axis  # errors are East, North
        for robot in _found(robots):
            colour = shades[robot.truth_id]
            frames = np.searchsorted(stamps, robot.stamps_ns)
            line, values = _broken(frames, robot.east_north[:, column])
            axes.plot(line, values, color=colour, linewidth=1.2)
            # Lines: overlapping filled bands of several robots would be illegible.
            _, sigma = _broken(frames, robot.sigmas[:, column])
            for sign in (-2.0, 2.0):
                axes.plot(line, sign * sigma, color=colour, linewidth=0.8, linestyle="--")
        axes.axhline(0.0, color=INK, linewidth=0.8)
        axes.set_ylabel(f"{title} error (m)")
        axes.grid(color=FAINT)
    panels[1].set_xlabel("frame")
    band = Line2D([], [], color=GREY, linewidth=0.8, linestyle="--", label="published two sigma")
    legend_above(figure, [*_names(robots, shades), band])
    return png(figure)


def range_png(robots: Sequence[RobotErrors], shades: Shades) -> bytes | None:
    """Draw the error against the horizontal distance from the drone; None if that is unknown."""
    known = [r for r in robots if len(r.range_m) and np.isfinite(r.range_m).any()]
    if not known:
        return None
    figure = Figure(figsize=(9, 4.4), layout="constrained")
    axes = figure.add_subplot()
    for robot in known:
        axes.plot(
            robot.range_m, robot.distance, ".", markersize=3, alpha=0.35,
            color=shades[robot.truth_id],
        )  # fmt: skip
    away = np.concatenate([r.range_m for r in known])
    error = np.concatenate([r.distance for r in known])
    lines = _binned(axes, away, error, np.concatenate([r.sigma for r in known]))
    axes.set_xlabel("horizontal distance from the drone (m)")
    axes.set_ylabel("error (m)")
    axes.set_ylim(bottom=0.0)
    axes.grid(color=FAINT)
    legend_above(figure, _names(known, shades, linestyle="none", marker=".") + lines)
    return png(figure)


def unseen_png(robots: Sequence[Unseen], shades: Shades) -> bytes | None:
    """Draw the error of predictions against the time since last seen; None without any."""
    if not robots:
        return None
    figure = Figure(figsize=(9, 4.4), layout="constrained")
    axes = figure.add_subplot()
    for one in robots:
        axes.plot(
            one.seconds, one.distance, ".", markersize=3, alpha=0.35, color=shades[one.truth_id]
        )
    every = [np.concatenate(part) for part in zip(*map(_parts, robots), strict=True)]
    lines = _binned(axes, *every)
    axes.set_xlabel("time since last seen (s)")
    axes.set_ylabel("error (m)")
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.grid(color=FAINT)
    names = [
        Line2D([], [], color=shades[one.truth_id], label=one.truth_id, linestyle="none", marker=".")
        for one in robots
    ]
    legend_above(figure, names + lines)
    return png(figure)


def _parts(one: Unseen) -> tuple[Array, Array, Array]:
    return one.seconds, one.distance, one.sigma


def _binned(axes: Any, away: Array, error: Array, sigma: Array) -> list[Any]:
    """Draw CEP and CE90 by bins of `away`; return the lines."""
    edges = np.linspace(np.nanmin(away), np.nanmax(away) + 1e-6, _BINS + 1)
    middle, median, high, stated = [], [], [], []
    for low, top in itertools.pairwise(edges):
        inside = (away >= low) & (away < top)
        if inside.sum() >= _LEAST_IN_BIN:
            middle.append(0.5 * (low + top))
            median.append(np.median(error[inside]))
            high.append(np.percentile(error[inside], 90))
            stated.append(np.sqrt(-2.0 * np.log(0.5)) * np.mean(sigma[inside]))
    return [
        *axes.plot(middle, median, "o-", color=INK, label="CEP (half are nearer)"),
        *axes.plot(middle, high, "s--", color=INK, label="CE90"),
        *axes.plot(middle, stated, "^:", color=GREY, label="CEP by the published covariance"),
    ]


def methods_png(methods: Mapping[str, Sequence[RobotErrors]], shades: Shades) -> bytes:
    """Draw the horizontal error over time, one panel per method."""
    columns = 1 if len(methods) <= _SIDE_BY_SIDE else 2
    rows = -(-len(methods) // columns)
    figure = Figure(figsize=(9, 0.8 + 1.9 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey="col", squeeze=False)
    starts = [r.stamps_ns[0] for robots in methods.values() for r in _found(robots)]
    start = min(starts, default=0)
    for axes, (method, robots) in zip(panels.T.flat, methods.items(), strict=False):
        for robot in _found(robots):
            seconds = (robot.stamps_ns - start) * 1e-9
            axes.plot(seconds, robot.distance, ".", markersize=3, color=shades[robot.truth_id])
        axes.set_ylabel("error (m)")
        axes.set_title(method, loc="left", fontsize=10)
        axes.set_ylim(bottom=0.0)
        axes.grid(color=FAINT)
    for axes in panels[-1]:
        utc_axis(axes, int(start))
    for axes in panels.T.flat[len(methods) :]:
        axes.set_visible(False)
    names = [
        Line2D([], [], color=shade, linestyle="none", marker=".", label=name)
        for name, shade in shades.items()
    ]
    legend_above(figure, names)
    return png(figure)
