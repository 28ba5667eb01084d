# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labels traced through waves against masks that Cycles renders; needs the extra [blender]."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("bpy", reason="bpy (the extra [blender], Python 3.11 only) is not installed")

from aerial_gnss_ros.simulation.blender import studio
from aerial_gnss_ros.simulation.blender.masks import SEEN, box_of, coverage
from aerial_gnss_ros.simulation.blender.picture import Order, render_sample
from aerial_gnss_ros.simulation.blender.ranges import RANGES
from aerial_gnss_ros.simulation.blender.shot import random_shot
from aerial_gnss_ros.simulation.blender.tracing import Tracer, box
from aerial_gnss_ros.simulation.samples import DatasetConfig
from aerial_gnss_ros.simulation.staging import Variety


@pytest.mark.parametrize("name", ["train", "unseen"])
@pytest.mark.parametrize("depth", [(-0.05, 0.05), (0.3, 1.0)], ids=["floating", "submerged"])
def test_boxes_are_those_of_the_rendered_mask(name: str, depth, tmp_path: Path) -> None:
    """To a pixel on each side, above and under waves that bend the sight lines."""
    variety = Variety(
        depth_m=depth, usual_long_px=(30.0, 90.0), usual=1.0, extra_robots=0.0, distractors=0.0
    )
    shot = random_shot(np.random.default_rng([3, 1]), RANGES[name], (160, 120), 1.0, None, variety)
    built = studio.build(replace(shot, robots=shot.robots[:1]), samples=32, seed=1)
    outline = Tracer(built).outline("aqua_01")
    assert outline is not None
    window = shot.view.window
    found = box(outline, window)
    assert found is not None
    share = coverage(built, "aqua_01", tmp_path)
    assert share.shape == (120, 160)
    assert int((share > SEEN).sum()) > 60
    assert found == pytest.approx(box_of(share, window), abs=1.0)


def test_one_order_gives_one_picture(tmp_path: Path) -> None:
    """The same bytes again, and labels in the picture."""
    config = DatasetConfig({}, (64, 48), occupied=1.0, renderer="blender", samples=1)
    one = render_sample(Order((5, 6), config), tmp_path)
    two = render_sample(Order((5, 6), config), tmp_path)
    assert one.image.shape == (48, 64, 3)
    assert (one.image == two.image).all()
    assert one.labels == two.labels
    assert one.about == two.about
    for label in one.labels:
        assert -0.5 <= label.left < label.right <= 63.5
        assert -0.5 <= label.top < label.bottom <= 47.5
