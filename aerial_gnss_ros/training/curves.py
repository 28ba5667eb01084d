# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Learning curves: one table and one figure over all phases."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from pathlib import Path

Row = dict[str, str]
LOSSES = ("box_loss", "cls_loss", "dfl_loss")
SCORES = {
    "metrics/precision(B)": "precision", "metrics/recall(B)": "recall",
    "metrics/mAP50(B)": "mAP50", "metrics/mAP50-95(B)": "mAP50-95",
}  # fmt: skip


def read_epochs(files: Sequence[Path]) -> list[Row]:
    """Return a row for each epoch of ultralytics' results.csv of each phase.

    Of an epoch repeated after a kill, only the last run counts.
    """
    rows: list[Row] = []
    for number, file in enumerate(files, start=1):
        if not file.is_file():
            continue
        epochs: dict[int, Row] = {}
        with file.open(newline="", encoding="utf-8") as stream:
            for row in csv.DictReader(stream, skipinitialspace=True):
                cells = {str(name).strip(): str(value).strip() for name, value in row.items()}
                if cells.get("epoch", "").isdecimal():
                    epochs[int(cells["epoch"])] = {"phase": str(number), **cells}
        rows += [epochs[epoch] for epoch in sorted(epochs)]
    return rows


def without_scores(row: Row) -> Row:
    """Return the row of an unscored epoch, for which ultralytics writes zeros."""
    return {name: cell for name, cell in row.items() if not name.startswith(("metrics/", "val/"))}


def as_csv(rows: Sequence[Row]) -> str:
    """Return the table; columns that only some rows have are left empty in others."""
    columns = list(dict.fromkeys(name for row in rows for name in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def draw_curves(rows: Sequence[Row], file: Path) -> None:
    """Write a PNG of losses and scores over all epochs, with a line at the start of each phase."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4), layout="constrained")
    FigureCanvasAgg(figure)
    loss, score = figure.subplots(1, 2)
    x = list(range(1, len(rows) + 1))
    for name in LOSSES:
        for split, style in (("train", "-"), ("val", "--")):
            values = [_number(row.get(f"{split}/{name}")) for row in rows]
            if not all(map(math.isnan, values)):
                label = f"{split} {name.removesuffix('_loss')}"
                loss.plot(x, values, style, marker=_marker(values), label=label)
    for column, name in SCORES.items():
        values = [_number(row.get(column)) for row in rows]
        score.plot(x, values, marker=_marker(values), label=name)
    for axes, title in ((loss, "loss"), (score, "scores on val")):
        axes.set(xlabel="epoch", title=title, xlim=(0.5, len(rows) + 0.5))
        axes.xaxis.get_major_locator().set_params(integer=True)
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small")
        for i in range(1, len(rows)):
            if rows[i]["phase"] != rows[i - 1]["phase"]:
                axes.axvline(i + 0.5, color="black", linewidth=1)
    score.set_ylim(0.0, 1.0)
    figure.savefig(file, format="png", dpi=100)


def _marker(values: Sequence[float]) -> str:
    """Return a dot for a single value, because its line would be invisible."""
    return "." if sum(map(math.isfinite, values)) == 1 else ""


def _number(text: str | None) -> float:
    try:
        return float(text or "nan")
    except ValueError:
        return float("nan")
