# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Colours and legends that are the same in every figure."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from aerial_gnss_ros.evaluation.picture import (
    COLOURS,
    colours,
    legend_above,
    north_arrow,
    png,
    utc_axis,
)


def test_each_name_has_a_colour_and_after_the_last_they_begin_again():
    names = [f"robot {i}" for i in range(len(COLOURS) + 1)]
    found = colours(names)
    assert list(found) == names
    assert found[names[0]] == found[names[-1]] == COLOURS[0]
    assert len(set(found.values())) == len(COLOURS)


def test_a_legend_makes_room_for_its_rows():
    heights = []
    for count in (0, 3, 9):
        figure = Figure(figsize=(6, 4), layout="constrained")
        axes = figure.add_subplot()
        legend_above(figure, [Line2D([], [], label=str(i)) for i in range(count)])
        figure.draw_without_rendering()
        heights.append(axes.get_position().y1)
        assert len(figure.legends) == (count > 0)
    assert heights[0] > heights[1] > heights[2]


def test_the_same_figure_gives_the_same_bytes():
    def drawn(value):
        figure = Figure(figsize=(1, 1))
        figure.add_subplot().plot([0, value])
        return png(figure)

    assert drawn(1) == drawn(1)
    assert drawn(1) != drawn(2)
    assert drawn(1).startswith(b"\x89PNG")


def test_seconds_are_labelled_with_utc():
    axes = Figure().add_subplot()
    utc_axis(axes, 1_763_769_599_500_000_000)  # 2025-11-21 23:59:59.5
    label = axes.xaxis.get_major_formatter()
    assert [label(x) for x in (0.0, 0.5, 60.5)] == ["23:59:59.5", "00:00:00", "00:01:00"]
    assert axes.get_xlabel() == "UTC, 2025-11-21"


def test_the_arrow_points_up_to_an_n():
    axes = Figure().add_subplot()
    north_arrow(axes)
    [arrow] = axes.texts
    assert arrow.get_text() == "N"
    assert arrow.xy[1] > arrow.xyann[1]
