# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads the platform's estimated errors over time, with their sigmas, from platform.csv.

A result folder may hold platform.csv with the columns `stamp_ns,error,value,sigma`: corrections to
be added to measured values, in SI units (rad, m, s).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.adapters.table_files import table_rows
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.samples import Array
from aerial_gnss_ros.text.sentences import cut

COLUMNS = ("stamp_ns", "error", "value", "sigma")
_DEGREES = ("heading", "pitch", "roll")
_HEADINGS = {
    "gnss_east": "GNSS offset, East",
    "gnss_north": "GNSS offset, North",
    "latency": "Latency of the images",
}


@dataclass(frozen=True)
class PlatformError:
    """One error over time.

    Attributes:
        stamps_ns: (n,) of images.
        value: (n,) SI.
        sigma: (n,) SI, one sigma.
    """

    stamps_ns: NDArray[np.int64]
    value: Array
    sigma: Array


def read_platform(path: Path) -> dict[str, PlatformError]:
    """Read platform.csv; a file that does not exist holds no errors.

    Raises:
        InputError: a column is missing, or a row has an invalid number.
    """
    if not path.is_file():
        return {}
    rows: dict[str, list[tuple[int, float, float]]] = {}
    for line, row in table_rows(path, COLUMNS, "the platform.csv of a replay"):
        try:
            values = int(row["stamp_ns"]), float(row["value"]), float(row["sigma"])
        except ValueError as error:
            raise InputError(f"{path}, line {line}: {cut(str(error))}.") from error
        if abs(values[0]) >= 1 << 63 or not all(map(math.isfinite, values[1:])):
            raise InputError(f"{path}, line {line}: a number is out of range.")
        rows.setdefault(row["error"], []).append(values)
    return {
        name: PlatformError(
            np.array([row[0] for row in found], dtype=np.int64),
            np.array([row[1] for row in found]),
            np.array([row[2] for row in found]),
        )
        for name, found in rows.items()
    }


def platform_png(errors: Mapping[str, PlatformError]) -> bytes:
    """Draw each error with its band of one and two sigma, one panel each.

    An error that the filter does not estimate (sigma 0 throughout) is left out.
    """
    # Matplotlib takes long to import, and who reads errors may draw none.
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    from aerial_gnss_ros.evaluation.picture import COLOURS, FAINT, INK, legend_above, png, utc_axis

    shown = {name: e for name, e in errors.items() if np.any(e.sigma > 0.0)} or dict(errors)
    rows = math.ceil(len(shown) / 2)
    figure = Figure(figsize=(9, 0.9 + 1.7 * rows), layout="constrained")
    panels = figure.subplots(rows, 2, sharex=True, squeeze=False)
    start = min(int(e.stamps_ns[0]) for e in shown.values())
    for axes in panels.flat[len(shown) :]:
        axes.set_visible(False)
    for axes, (name, error) in zip(panels.flat, shown.items(), strict=False):
        angle = any(word in name for word in _DEGREES)
        scale = math.degrees(1.0) if angle else 1.0
        unit = "deg" if angle else "s" if "latency" in name else "m"
        seconds = (error.stamps_ns - start) * 1e-9
        value, sigma = scale * error.value, scale * error.sigma
        for width in (2.0, 1.0):
            axes.fill_between(
                seconds, value - width * sigma, value + width * sigma, color=COLOURS[0],
                alpha=0.15, linewidth=0,
            )  # fmt: skip
        axes.plot(seconds, value, color=COLOURS[0], linewidth=1.2)
        axes.axhline(0.0, color=INK, linewidth=0.6)
        axes.set_title(_words(name), loc="left", fontsize=10)
        axes.set_ylabel(f"correction ({unit})")
        axes.grid(color=FAINT)
    for axes in panels[-1]:
        utc_axis(axes, start)
    bands = [
        Line2D([], [], color=COLOURS[0], linewidth=1.2, label="estimate"),
        Patch(color=COLOURS[0], alpha=0.3, linewidth=0, label="one sigma"),
        Patch(color=COLOURS[0], alpha=0.15, linewidth=0, label="two sigma"),
    ]
    legend_above(figure, bands)
    return png(figure)


def _words(name: str) -> str:
    """Return gnss_east as "GNSS offset, East", a heading."""
    return _HEADINGS.get(name, name.replace("_", " ").capitalize())
