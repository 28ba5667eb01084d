# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The rendered robot has the size of the real one, and its flippers move."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.simulation.hexapod import LIVERIES, RobotState, hexapod
from aerial_gnss_ros.simulation.robot_models import placed_robot


@pytest.mark.parametrize("livery", sorted(LIVERIES))
def test_size(livery: str) -> None:
    """About 0.65 m x 0.45 m; flippers may reach a little over at the tail and the sides."""
    for phase in np.linspace(0.0, 2.0 * np.pi, 7):
        span = np.ptp(hexapod(float(phase), livery).vertices, axis=0)
        assert 0.65 <= span[0] < 0.85
        assert 0.45 <= span[1] < 0.56
        assert 0.13 <= span[2] < 0.45


def test_flippers_beat() -> None:
    """Half a beat later the two tripods have changed places: the mirror image."""
    now, later = hexapod(0.7).vertices, hexapod(0.7 + np.pi).vertices
    assert np.abs(now - later).max() > 0.05
    mirrored = later * np.array([1.0, -1.0, 1.0])
    distance = np.linalg.norm(now[:, None] - mirrored[None], axis=-1).min(axis=1)
    assert distance.max() < 0.01


def test_placing() -> None:
    """Course 90 deg points the nose north; depth lowers the hull's middle."""
    mesh = placed_robot(RobotState("aqua_1", 10.0, 20.0, np.pi / 2, depth=0.4))
    nose = mesh.vertices[np.argmax(mesh.vertices[:, 1])]
    assert nose[1] == pytest.approx(20.325, abs=0.01)
    assert nose[0] == pytest.approx(10.0, abs=0.1)
    hull = hexapod(0.0).vertices[:72]
    assert mesh.vertices[:72, 2].mean() == pytest.approx(hull[:, 2].mean() - 0.4, abs=1e-9)
