# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which drone saw which robot, and when."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from aerial_gnss_ros.bags.drone_tables import DroneFlight
from aerial_gnss_ros.bags.results import PLATFORM_STEP_NS
from aerial_gnss_ros.evaluation.picture import FAINT, GREY, INK, legend_above, png, utc_axis

_HEIGHT = 0.36
"""Of a bar; rows of drones are 0.5 apart, robots 0.5 each drone and 0.5."""
_GAP_NS = round(1.6 * PLATFORM_STEP_NS)
_NANOSECONDS = 1e9


def seen_by_png(drones: Mapping[str, DroneFlight], shades: Mapping[str, str]) -> bytes | None:
    """Draw when each drone saw each robot; None where none saw any.

    Args:
        drones: by name.
        shades: colours of the robots.
    """
    robots = sorted({robot for one in drones.values() for robot in one.seen})
    if not robots:
        return None
    begin_ns = min(int(one.path.stamps_ns[0]) for one in drones.values())
    rows = len(robots) * (0.5 * len(drones) + 0.5)
    figure = Figure(figsize=(9, 1.3 + 0.45 * rows), layout="constrained")
    axes = figure.add_subplot()
    y, ticks = 0.0, list[tuple[float, str]]()
    for robot in robots:
        for name, one in drones.items():
            seen = spans(one.seen.get(robot, np.zeros(0, np.int64)), begin_ns)
            flown = spans(one.path.stamps_ns, begin_ns)
            axes.broken_barh(flown, (y - 0.5 * _HEIGHT, _HEIGHT), facecolor=FAINT)
            shade = shades.get(robot, GREY)
            axes.broken_barh(seen, (y - 0.5 * _HEIGHT, _HEIGHT), facecolor=shade)
            ticks.append((y, f"{robot}  by {name}"))
            y += 0.5
        y += 0.5
    axes.set_yticks([place for place, _ in ticks], [words for _, words in ticks])
    axes.invert_yaxis()
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0, colors=INK)
    utc_axis(axes, begin_ns)
    legend_above(
        figure,
        [
            Line2D([], [], color=GREY, linewidth=6, label="in its images"),
            Patch(color=FAINT, label="flies, and is not known to see it"),
        ],
    )
    return png(figure)


def spans(
    stamps_ns: np.ndarray[tuple[int, ...], np.dtype[np.int64]], begin_ns: int
) -> list[tuple[float, float]]:
    """Return beginning and length of each run of stamps without a gap, s.

    Args:
        stamps_ns: (n,) each half second, ordered.
        begin_ns: from which seconds count.
    """
    if not len(stamps_ns):
        return []
    parts = np.split(stamps_ns, np.flatnonzero(np.diff(stamps_ns) > _GAP_NS) + 1)
    return [
        (
            (int(part[0]) - begin_ns) / _NANOSECONDS,
            (int(part[-1] - part[0]) + PLATFORM_STEP_NS) / _NANOSECONDS,
        )
        for part in parts
    ]
