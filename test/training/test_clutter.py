# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Things that are no robots are of the wanted size, everywhere but on robots."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.training import clutter
from aerial_gnss_ros.training.clutter import Numbers, add_things, main

NONE = Numbers(0.0)
GLYPH = np.full((60, 40, 4), 255, np.uint8)
WATER = np.full((160, 200, 3), (90, 100, 80), np.uint8)


def test_robots_stay_as_they_are_and_other_water_does_not():
    robots = np.array([[60.0, 50.0, 100.0, 80.0]])
    kept = slice(50, 81), slice(60, 101)
    changed = np.zeros(WATER.shape[:2])
    for seed in range(40):
        made = add_things(np.random.default_rng(seed), WATER, robots, Numbers())
        # A thing of any size keeps a third of its side away.
        np.testing.assert_array_equal(made[kept], WATER[kept])
        changed += np.abs(made.astype(int) - WATER).max(axis=-1) > 20
    assert (changed[:, 150:] > 0).mean() > 0.9
    assert changed[:, 150:].mean() > 2.0
    again = add_things(np.random.default_rng(39), WATER, robots, Numbers())
    np.testing.assert_array_equal(again, made)


@pytest.mark.parametrize(
    "numbers",
    [Numbers(0.0, people=6.0), Numbers(0.0, figures=6.0), Numbers(0.0, drawings=6.0)],
)
def test_people_figures_and_drawings_come_besides_the_things_and_keep_off_robots_too(numbers):
    robots = np.array([[60.0, 50.0, 100.0, 80.0]])
    changed = 0
    for seed in range(20):
        assert np.array_equal(add_things(np.random.default_rng(seed), WATER, robots, NONE), WATER)
        made = add_things(np.random.default_rng(seed), WATER, robots, numbers, glyphs=[GLYPH])
        np.testing.assert_array_equal(made[50:81, 60:101], WATER[50:81, 60:101])
        changed += int((made != WATER).any())
    assert changed > 10


def test_half_of_the_figures_have_some_alike_beside_them(monkeypatch):
    disc = np.zeros((11, 11), np.float32)
    cv2.circle(disc, (5, 5), 3, 1.0, -1)
    monkeypatch.setattr(
        clutter, "figure", lambda *_: (disc, np.full((11, 11, 3), 250.0, np.float32))
    )
    counts = []
    for seed in range(400):
        rng = np.random.default_rng(seed)
        made = add_things(rng, WATER, np.zeros((0, 4)), Numbers(0.0, figures=0.2))
        changed = (np.abs(made.astype(int) - WATER).max(axis=-1) > 25).astype(np.uint8)
        counts.append(cv2.connectedComponents(changed)[0] - 1)
    drawn = [count for count in counts if count]
    assert 40 < len(drawn) < 90  # of 73 with one or more
    assert 0.3 < np.mean(np.array(drawn) > 1) < 0.7


def test_the_command_keeps_labels(tmp_path, capsys):
    folder = tmp_path / "set"
    for kind in ("images", "labels"):
        (folder / kind / "train").mkdir(parents=True)
    cv2.imwrite(str(folder / "images/train/a.png"), WATER)
    (folder / "labels/train/a.txt").write_text("0 0.4 0.4 0.2 0.2\n")
    (folder / "meta.csv").write_text("image,split\n")
    output = tmp_path / "out"
    command = [str(folder), "-o", str(output), "--things", "40"]
    assert main(command) == 0
    assert "1 images" in capsys.readouterr().out
    assert (output / "labels/train/a.txt").read_text() == "0 0.4 0.4 0.2 0.2\n"
    assert (output / "meta.csv").read_text() == "image,split\n"
    assert np.abs(cv2.imread(str(output / "images/train/a.jpg")).astype(int) - WATER).max() > 20
    for wrong, words in (
        (command, "exists already"),
        ([*command[:2], "x", "--things", "-1"], "0 or"),
        ([*command[:2], "x", "--drawings", "2"], "--font"),
    ):
        arguments = [a if a != "x" else str(tmp_path / "new") for a in wrong]
        assert main(arguments) == 2
        assert words in capsys.readouterr().err
    assert not (tmp_path / "new").exists()
