# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Boxes and robots for tests of scores, and a detector that always finds the same."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.training.labelled import Truth


def found(*rows: tuple[float, ...]) -> Detections:
    """Boxes of (left, top, right, bottom, score)."""
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    centre = (table[:, :2] + table[:, 2:4]) / 2
    return Detections(
        np.hstack([centre, table[:, 2:4] - table[:, :2]]),
        table[:, 4],
        np.zeros(len(table), np.int64),
        ("aqua",),
    )


def truth(*rows: tuple[float, ...], contrast: float = 0.3) -> Truth:
    """Robots of (left, top, right, bottom, counted)."""
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    return Truth(
        table[:, :4],
        table[:, 4] > 0,
        (table[:, 2:4] - table[:, :2]).max(axis=1, initial=0.0),
        np.full(len(table), contrast),
        np.zeros(len(table), np.int64),
    )


ROBOT = (0.0, 0.0, 40.0, 20.0, 1.0)


class Fixed:
    """A detector that always finds the same."""

    name, class_names = "fixed", ("aqua",)

    def detect(self, _):
        return found((0, 0, 40, 20, 0.72), (200, 0, 240, 20, 0.33), (300, 0, 340, 20, 0.21))


def truth_of(*corners):
    """Return robots that count, 20 px long."""
    count = len(corners)
    return Truth(
        np.array(corners, float).reshape(-1, 4), np.ones(count, bool), np.full(count, 20.0),
        np.full(count, np.nan), np.zeros(count, np.int64),
    )  # fmt: skip
