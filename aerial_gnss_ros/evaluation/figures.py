# SPDX-License-Identifier: Apache-2.0
"""The paper's figures: error over frames, latitude and longitude error; and error against range."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from aerial_gnss_ros.core.values import Array
from aerial_gnss_ros.evaluation.errors import RobotErrors
from aerial_gnss_ros.evaluation.picture import COLOURS, png

_BINS = 8
_LEAST_IN_BIN = 5


def _frames(robots: Sequence[RobotErrors]) -> NDArray[np.int64]:
    """Return the stamps of all compared images; a stamp's place among them is its frame."""
    stamps = [robot.stamps_ns for robot in robots]
    return np.unique(np.concatenate(stamps)) if stamps else np.zeros(0, dtype=np.int64)


def _label(robot: RobotErrors) -> str:
    return (
        robot.truth_id
        if robot.robot_id == robot.truth_id
        else (f"{robot.truth_id} (as {robot.robot_id})")
    )


def _broken(frames: NDArray[np.signedinteger[Any]], values: Array) -> tuple[Array, Array]:
    """Return a line that is interrupted where frames are missing."""
    gaps = np.flatnonzero(np.diff(frames) > 5) + 1
    return np.insert(frames.astype(float), gaps, np.nan), np.insert(values, gaps, np.nan)


def frames_png(robots: Sequence[RobotErrors]) -> bytes:
    """Draw the haversine error over frames, one line a robot, as the paper does."""
    figure = Figure(figsize=(9, 3.6), layout="constrained")
    axes = figure.add_subplot()
    stamps = _frames(robots)
    for index, robot in enumerate(robots):
        if not len(robot.stamps_ns):
            continue
        colour = COLOURS[index % len(COLOURS)]
        frames, values = _broken(np.searchsorted(stamps, robot.stamps_ns), robot.haversine)
        axes.plot(frames, values, color=colour, linewidth=1.2, label=_label(robot))
        mean = float(np.mean(robot.haversine))
        axes.axhline(mean, color=colour, linewidth=0.8, linestyle=":")
    axes.set_xlabel("frame")
    axes.set_ylabel("haversine error (m)")
    axes.set_ylim(bottom=0.0)
    axes.grid(color="#dddddd")
    axes.legend(loc="upper right", fontsize=8)
    axes.set_title("dotted: mean", loc="right", fontsize=8, color="#5a6b78")
    return png(figure)


def axes_png(robots: Sequence[RobotErrors]) -> bytes:
    """Draw latitude and longitude error over frames in metres, with bands of two sigma."""
    figure = Figure(figsize=(9, 5.2), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True, sharey=True)
    stamps = _frames(robots)
    for axis, (axes, title) in enumerate(zip(panels, ("latitude", "longitude"), strict=True)):
        column = 1 - axis  # errors are East, North
        for index, robot in enumerate(robots):
            if not len(robot.stamps_ns):
                continue
            colour = COLOURS[index % len(COLOURS)]
            frames = np.searchsorted(stamps, robot.stamps_ns)
            line, values = _broken(frames, robot.east_north[:, column])
            _, sigma = _broken(frames, robot.sigma)
            axes.plot(line, values, color=colour, linewidth=1.2, label=_label(robot))
            axes.fill_between(line, -2.0 * sigma, 2.0 * sigma, color=colour, alpha=0.07)
        axes.axhline(0.0, color="#1b2733", linewidth=0.8)
        axes.set_ylabel(f"{title} error (m)")
        axes.grid(color="#dddddd")
    panels[0].legend(loc="upper right", fontsize=8)
    panels[0].set_title("band: published two sigma", loc="right", fontsize=8, color="#5a6b78")
    panels[1].set_xlabel("frame")
    return png(figure)


def range_png(robots: Sequence[RobotErrors]) -> bytes | None:
    """Draw the error against the horizontal distance from the drone; None where that is unknown."""
    known = [r for r in robots if len(r.range_m) and np.isfinite(r.range_m).any()]
    if not known:
        return None
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    axes = figure.add_subplot()
    for index, robot in enumerate(robots):
        if not len(robot.range_m):
            continue
        axes.plot(
            robot.range_m, robot.distance, ".", markersize=3, alpha=0.35,
            color=COLOURS[index % len(COLOURS)], label=_label(robot),
        )  # fmt: skip
    away = np.concatenate([r.range_m for r in known])
    error = np.concatenate([r.distance for r in known])
    sigma = np.concatenate([r.sigma for r in known])
    edges = np.linspace(np.nanmin(away), np.nanmax(away) + 1e-6, _BINS + 1)
    middle, median, high, stated = [], [], [], []
    for low, top in itertools.pairwise(edges):
        inside = (away >= low) & (away < top)
        if inside.sum() >= _LEAST_IN_BIN:
            middle.append(0.5 * (low + top))
            median.append(np.median(error[inside]))
            high.append(np.percentile(error[inside], 90))
            stated.append(np.sqrt(-2.0 * np.log(0.5)) * np.mean(sigma[inside]))
    axes.plot(middle, median, "o-", color="#1b2733", label="CEP (half are nearer)")
    axes.plot(middle, high, "s--", color="#1b2733", label="CE90")
    axes.plot(middle, stated, "^:", color="#5a6b78", label="CEP by the published covariance")
    axes.set_xlabel("horizontal distance from the drone (m)")
    axes.set_ylabel("error (m)")
    axes.set_ylim(bottom=0.0)
    axes.grid(color="#dddddd")
    legend = figure.legend(loc="outside upper center", fontsize=8, ncols=3)
    for handle in legend.legend_handles:
        if handle is not None:
            handle.set_alpha(1.0)
    return png(figure)
