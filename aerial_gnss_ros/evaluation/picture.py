# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Common parts of all figures: colours, the legend above, PNG."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping
from datetime import datetime, timezone
from typing import Any

from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import FuncFormatter, MaxNLocator

# Okabe and Ito's colours, distinguishable for the colour-blind, without yellow, which is too pale
# for print.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
INK, GREY, FAINT = "#1b2733", "#5a6b78", "#dddddd"
_COLUMNS = 4
"""Entries of a legend side by side."""
_ROW = 0.2
"""Height of a line of a legend, inches."""


def colours(names: Iterable[str]) -> Mapping[str, str]:
    """Return a colour for each name, in the order of names; the same in every figure."""
    return {name: COLOURS[index % len(COLOURS)] for index, name in enumerate(names)}


def legend_above(figure: Figure, handles: list[Any]) -> None:
    """Put a legend above the axes, where it hides nothing; no entries, no legend."""
    if not handles:
        return
    figure.legend(
        handles=handles, loc="upper center", fontsize=9,
        ncols=min(len(handles), _COLUMNS), frameon=False,
    )  # fmt: skip
    layout = figure.get_layout_engine()
    # loc="outside …" would do it, but only from Matplotlib 3.7 on; Ubuntu 24.04 has 3.6.
    if isinstance(layout, ConstrainedLayoutEngine):
        rows = -(-len(handles) // _COLUMNS)
        layout.set(rect=(0.0, 0.0, 1.0, 1.0 - (_ROW * rows + _ROW) / figure.get_figheight()))


def utc_axis(axes: Any, start_ns: int) -> None:
    """Label an axis of seconds since a stamp with UTC, as logs and other instruments have it.

    Args:
        axes: whose x is in s.
        start_ns: stamp at x = 0, ns since 1970.
    """
    day = datetime.fromtimestamp(start_ns // 1_000_000_000, tz=timezone.utc)

    def clock(seconds: float, _position: int | None = None) -> str:
        tenths = (start_ns + round(seconds * 1e9)) // 100_000_000
        time = datetime.fromtimestamp(tenths // 10, tz=timezone.utc)
        return f"{time:%H:%M:%S}" + (f".{tenths % 10}" if tenths % 10 else "")

    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.xaxis.set_major_formatter(FuncFormatter(clock))
    axes.set_xlabel(f"UTC, {day:%Y-%m-%d}")


def north_arrow(axes: Any) -> None:
    """Draw an arrow to the north into a map's upper right corner; north is up."""
    axes.annotate(
        "N", xy=(0.965, 0.97), xytext=(0.965, 0.87), xycoords="axes fraction",
        ha="center", va="center", color=INK, fontsize=10, annotation_clip=False,
        arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.2},
    )  # fmt: skip


def png(figure: Figure) -> bytes:
    """Return a figure as PNG, fine enough for print."""
    buffer = io.BytesIO()
    # Without the software entry, equal figures have equal bytes.
    figure.savefig(buffer, format="png", dpi=160, metadata={"Software": None})
    return buffer.getvalue()
