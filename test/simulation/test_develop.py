# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Exposure, tone and processing of a camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.simulation.develop import TARGET, Developer
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.view import Window

PLAIN = replace(
    Scene(), noise=0.0, blur_px=0.0, vignette=0.0, saturation=1.0, exposure=1.0,
    white_balance=(1.0, 1.0, 1.0), motion_px=(0.0, 0.0),
)  # fmt: skip
SIZE = (64, 48)


def grey(value):
    return [np.full(SIZE[::-1], value, np.float32) for _ in range(3)]


def toned(scene, planes, gain=1.0):
    return Developer(scene).tone(planes, gain, Window(0, 0, *SIZE), SIZE)


@pytest.mark.parametrize("level", [0.02, 0.5, 4.0])
def test_the_exposure_brings_a_picture_to_its_target(level):
    assert Developer(PLAIN).gain(grey(level)) * level == pytest.approx(TARGET)
    twice = replace(PLAIN, exposure=2.0)
    assert Developer(twice).gain(grey(level)) * level == pytest.approx(2.0 * TARGET)


def test_bright_parts_do_not_burn_out():
    planes = grey(0.01)
    for plane in planes:
        plane[:12] = 10.0
    assert Developer(PLAIN).gain(planes) * 10.0 == pytest.approx(0.95)


def test_tones_are_srgb_and_highlights_roll_off():
    """Linear 0.2140 is half of sRGB (IEC 61966-2-1); above one half less and less is added."""
    assert toned(PLAIN, grey(0.214))[0, 0].tolist() == pytest.approx([128] * 3, abs=1)
    assert toned(PLAIN, grey(0.0))[0, 0].tolist() == [0] * 3
    levels = [int(toned(PLAIN, grey(v))[0, 0, 0]) for v in (0.5, 1.0, 1.5, 2.0, 9.0)]
    steps = np.diff(levels)
    assert levels == sorted(levels)
    assert steps[0] > steps[1] > steps[2]
    assert levels[-1] <= 255


def test_grey_stays_grey_whatever_the_saturation_and_white_balance_tints_it():
    for saturation in (0.0, 0.5, 1.5):
        pixel = toned(replace(PLAIN, saturation=saturation), grey(0.2))[0, 0]
        assert np.ptp(pixel.astype(int)) <= 1
    blue, green, red = toned(replace(PLAIN, white_balance=(2.0, 1.0, 0.5)), grey(0.2))[0, 0]
    assert blue > green > red


def test_a_vignette_darkens_the_corners_alone():
    found = toned(replace(PLAIN, vignette=0.5), grey(0.3)).astype(int)
    assert found[24, 32, 0] == pytest.approx(int(toned(PLAIN, grey(0.3))[0, 0, 0]), abs=1)
    assert found[0, 0, 0] < found[0, 32, 0] < found[24, 32, 0]
    assert found[0, 0, 0] == pytest.approx(found[-1, -1, 0], abs=1)


def test_noise_is_of_the_frame_and_blurs_move_nothing():
    image = np.full((48, 64, 3), 100, np.uint8)
    noisy = Developer(replace(PLAIN, noise=4.0))
    one, again, other = (noisy.finish(image, seed) for seed in (1, 1, 2))
    assert (one == again).all()
    assert (one != other).any()
    assert one.astype(float).std() == pytest.approx(4.0, rel=0.1)
    assert (Developer(PLAIN).finish(image, 1) == image).all()
    dot = np.zeros((49, 65, 3), np.uint8)
    dot[20:29, 28:37] = 200
    for scene in (replace(PLAIN, blur_px=1.0), replace(PLAIN, motion_px=(4.0, 2.0))):
        rows, columns = np.nonzero(Developer(scene).finish(dot, 1)[..., 0])
        assert (rows.min() + rows.max(), columns.min() + columns.max()) == (48, 64)
        assert len(rows) > 81
