# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The map shows what its legend says, and a robot has one colour in all pictures."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_hex

from aerial_gnss_ros.bags.drone_tables import DroneFlight
from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.evaluation.picture import COLOURS
from aerial_gnss_ros.evaluation.track_map import map_figure

STAMPS = np.arange(4, dtype=np.int64) * 10**9
STILL = Track(STAMPS, np.full(4, 0.23), np.full(4, -1.04))


def _estimate(measured):
    covariance = np.tile(np.eye(2), (4, 1, 1))
    return EstimatedTrack(STAMPS, STILL.latitude, STILL.longitude, covariance, np.array(measured))


def _signs(figure):
    (legend,) = figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    # its name before Matplotlib 3.7
    handles = getattr(legend, "legend_handles", None) or legend.legendHandles
    return dict(zip(texts, handles, strict=True))


def test_the_legend_explains_what_is_drawn_and_nothing_else():
    seen, lost = _estimate([True] * 4), _estimate([True, True, False, False])
    signs = _signs(map_figure({"aqua_1": seen, "aqua_2": lost}, {"a": STILL}, STILL))
    assert signs["truth (×: at the end)"].get_marker() == "x"  # a still robot's truth is only that
    assert signs["truth (×: at the end)"].get_linestyle() == "--"
    assert signs["drone (▲: at the end)"].get_marker() == "^"
    assert signs["coasting (not seen)"].get_linestyle() == ":"
    assert to_hex(signs["aqua_2"].get_color()) == COLOURS[1].lower()
    assert set(_signs(map_figure({"aqua_1": seen}, {}))) == {
        "aqua_1", "95 % ellipse", "last ellipse"
    }  # fmt: skip


def test_a_map_of_nothing_has_no_legend():
    assert map_figure({}, {}).legends == []


def test_a_robot_never_measured_is_on_the_map():
    figure = map_figure({"aqua_1": _estimate([False] * 4)}, {})
    assert [text.get_text() for text in figure.axes[0].texts] == ["aqua_1", "N"]


def test_each_drone_has_its_path_its_name_and_lines_to_what_its_last_image_shows():
    robot = _estimate([True] * 4)
    away = Track(STAMPS, STILL.latitude + 1e-6, STILL.longitude + 1e-6)
    drones = {"a": DroneFlight(away, {"aqua_1": STAMPS}), "b": DroneFlight(STILL, {})}
    drones["b"].seen["aqua_1"] = STAMPS[:2]
    figure = map_figure({"aqua_1": robot}, {}, STILL, drones)
    axes = figure.axes[0]
    assert sorted(text.get_text() for text in axes.texts) == ["N", "a", "aqua_1", "b"]
    assert [line.get_marker() for line in axes.lines].count("^") == 2  # not that of `drone`
    (sight,) = [line for line in axes.lines if len(line.get_xdata()) == 2]
    assert np.hypot(*np.ptp(sight.get_xydata(), axis=0)) == pytest.approx(8.9, abs=0.3)
    assert {"drone (▲: at the end)", "in the drone's last image"} <= set(_signs(figure))
