# SPDX-License-Identifier: Apache-2.0
"""What all pictures of a result have in common: colours, the legend above, PNG."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping
from typing import Any

from matplotlib.figure import Figure

# Okabe and Ito's colours: told apart by the colour-blind too. Yellow is too pale for print.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
INK, GREY, FAINT = "#1b2733", "#5a6b78", "#dddddd"
_COLUMNS = 4
"""Entries of a legend side by side."""


def colours(names: Iterable[str]) -> Mapping[str, str]:
    """Return a colour by name, in the order of the names; the same in every picture."""
    return {name: COLOURS[index % len(COLOURS)] for index, name in enumerate(names)}


def legend_above(figure: Figure, handles: list[Any]) -> None:
    """Put a legend above the axes, where it hides nothing; without entries there is none."""
    if handles:
        figure.legend(
            handles=handles, loc="outside upper center", fontsize=9,
            ncols=min(len(handles), _COLUMNS), frameon=False,
        )  # fmt: skip


def png(figure: Figure) -> bytes:
    """Return a figure as PNG, fine enough for print."""
    buffer = io.BytesIO()
    # Without the software entry the same figure gives the same bytes.
    figure.savefig(buffer, format="png", dpi=160, metadata={"Software": None})
    return buffer.getvalue()
