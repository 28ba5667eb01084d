# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Things of no kind: never twice the same, and no change to what was drawn without them."""

import numpy as np
import pytest

from aerial_gnss_ros.simulation.filling import random_stage
from aerial_gnss_ros.simulation.flotsam import flotsam, random_colour
from aerial_gnss_ros.simulation.staging import Variety


@pytest.mark.parametrize("seed", range(40))
def test_a_thing_is_a_sound_mesh_of_a_size_that_floats_about(seed: int) -> None:
    mesh = flotsam(np.random.default_rng(seed))
    again = flotsam(np.random.default_rng(seed))
    np.testing.assert_array_equal(mesh.vertices, again.vertices)
    assert np.isfinite(mesh.vertices).all()
    assert mesh.faces.min() >= 0
    assert mesh.faces.max() < len(mesh.vertices)
    assert mesh.colours.min() >= 0.0
    assert mesh.colours.max() <= 0.85
    assert 0.02 < np.ptp(mesh.vertices[:, :2], axis=0).max() < 6.0


def test_colours_are_reflectances_of_lacquer() -> None:
    colours = np.array([random_colour(np.random.default_rng(seed)) for seed in range(200)])
    assert colours.min() >= 0.02
    assert colours.max() <= 0.8
    grey = np.ptp(colours, axis=1) == 0.0
    assert 0.3 < grey.mean() < 0.5  # 0.4 are grey


def test_flotsam_comes_on_top_of_a_scene_and_changes_nothing_else_in_it() -> None:
    more = 0
    for seed in range(12):
        plain, full = (
            random_stage(np.random.default_rng(seed), (320, 320), 0.8, variety=Variety(flotsam=f))
            for f in (0.0, 3.0)
        )
        assert full.robots == plain.robots
        assert full.height == plain.height
        for old, new in zip(plain.props, full.props, strict=False):
            np.testing.assert_array_equal(old.vertices, new.vertices)
        more += len(full.props) - len(plain.props)
    assert more > 12
