# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One filter for each latency, under a camera that looks down: numbers checked by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.filter.latency_bank import TUNING, BankObservation, LatencyBank
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.models.motion_model import MotionModel

HEIGHT_M, FOCAL_PX, STEP_S = 18.0, 900.0, 0.5
METRE_PX = FOCAL_PX / HEIGHT_M
DOWN = matrix_from_rpy(0.0, 0.5 * math.pi, 0.0)
SPEED = math.hypot(0.4, TUNING.feigned_speed_mps)  # 0.5 m/s


def platform(gnss_white=0.0, gnss_slow=0.0):
    """Return a platform whose boxes are exact to 1 px, with errors of its position alone, m²."""

    def stationary(fix):
        return np.diag([*([gnss_slow] * 2 if fix is None else fix), *[0.0] * 5])

    return SimpleNamespace(
        white=np.array([gnss_white, gnss_white, 0.0, 0.0, 0.0, 0.0]), pixel=1.0,
        correlation_time_s=60.0, stationary=stationary,
    )  # fmt: skip


def at(right=0.0, below=0.0):
    """Return a pixel relative to the image's middle."""
    return np.array([640.0 + right, 360.0 + below])


def bank(count=1, model=None):
    return LatencyBank(model or platform(), MotionModel(0.0, 0.4), count)


def seen(sea, found, t, pixels, east=(0.0,), fix=None, looks=DOWN):
    """Show an image with boxes by name to a bank whose cameras are so far east, m."""
    now = BankObservation(
        round(t * 1e9), sea.camera, {name: np.array(one) for name, one in pixels.items()}, fix
    )
    positions = np.array([[one, 0.0, HEIGHT_M] for one in east])
    passed = STEP_S if t else 0.0
    return found.update(now, passed, positions, np.broadcast_to(looks, (len(east), 3, 3)))


def expected(white=0.0, slow=0.0):
    """Return the variance of a box in the second image, px²."""
    began = METRE_PX**-2 + white
    drift = TUNING.drift_density**2 * STEP_S**3 / 3.0
    moved = (SPEED * STEP_S) ** 2 + drift + slow * 2.0 * STEP_S / 60.0
    return METRE_PX**2 * (began + moved + white) + 1.0


@pytest.mark.parametrize(("white", "slow"), [(0.0, 0.0), (0.25, 0.0), (0.0, 4.0)])
@pytest.mark.parametrize("sigmas", [1.0, 2.9, 3.1, 10.0])
def test_a_box_costs_its_squared_residual_and_beyond_three_sigmas_less(sea, white, slow, sigmas):
    found, spread = bank(model=platform(white, slow)), expected(white, slow)
    assert seen(sea, found, 0.0, {"a": at()}) is None
    fit = seen(sea, found, STEP_S, {"a": at(sigmas * math.sqrt(spread))})
    cost = sigmas**2 if sigmas < 3.0 else 3.0 * (2.0 * sigmas - 3.0)
    assert fit.cost == pytest.approx([cost + 2.0 * math.log(spread)])
    assert fit.squares == pytest.approx([min(sigmas**2, TUNING.most_squared)])
    assert fit.noise == pytest.approx([2.0 * white * METRE_PX**2 / spread])


def test_the_fix_says_itself_how_far_its_slow_errors_go(sea):
    found, spread = bank(), expected(slow=9.0)
    seen(sea, found, 0.0, {"a": at()})
    fit = seen(sea, found, STEP_S, {"a": at()}, fix=np.array([9.0, 9.0]))
    assert fit.cost == pytest.approx([2.0 * math.log(spread)])


def test_a_robot_is_corrected_by_its_box_and_an_outlier_counts_less(sea):
    """Beyond three sigmas a box moves its robot as far as one at three sigmas does."""
    moved = []
    for sigmas in (1.0, 3.0, 6.0):
        found, spread = bank(), expected()
        seen(sea, found, 0.0, {"a": at()})
        seen(sea, found, STEP_S, {"a": at(sigmas * math.sqrt(spread))})
        moved.append(-found._state[0, 0, 1])  # right in the image is south
    share = 1.0 - 1.0 / expected()
    assert moved == pytest.approx(np.array([1.0, 3.0, 3.0]) * share * math.sqrt(spread) / METRE_PX)


def test_a_robot_is_expected_to_go_on_as_it_moves(sea):
    squares = []
    for pixels in (16.0, 8.0, 0.0):
        found = bank()
        for t, right in ((0.0, 0.0), (STEP_S, 8.0), (2.0 * STEP_S, pixels)):
            fit = seen(sea, found, t, {"a": at(right)})
        squares.append(float(fit.squares[0]))
    assert squares[0] < 0.01 < squares[1] < squares[2]


def test_the_latency_with_which_robots_stay_costs_least(sea):
    """A camera that swings 2 m to and fro; images show what was 0.2 s before their stamps."""
    late_s = np.array([-0.2, 0.0, 0.2, 0.4])
    found, total = bank(len(late_s)), np.zeros(len(late_s))
    swing = lambda t: 2.0 * np.sin(1.5 * t)  # noqa: E731
    for i in range(40):
        t = STEP_S * i
        # Ahead is east, and up in the image.
        pixels = {"a": at(0.0, METRE_PX * swing(t - 0.2))}
        fit = seen(sea, found, t, pixels, swing(t - late_s))
        total += 0.0 if fit is None else fit.cost
    assert np.argmin(total) == 2
    assert np.sort(total)[1] - total[2] > 20.0


def test_a_latency_that_puts_a_robot_behind_the_camera_is_unlikely(sea):
    found = bank(2)
    seen(sea, found, 0.0, {"a": at()}, (0.0, 0.0))
    fit = seen(sea, found, STEP_S, {"a": at()}, (0.0, 0.0), looks=np.array([DOWN, DOWN.T]))
    assert fit.cost[1] == TUNING.out_of_view_cost
    assert fit.cost[0] == pytest.approx(2.0 * math.log(expected()))


def test_robots_long_unseen_begin_anew_and_no_more_than_four_are_followed(sea):
    found = bank()
    five = {name: at(20.0 * i) for i, name in enumerate("abcde")}
    seen(sea, found, 0.0, five)
    assert list(found._seen_ns) == list("abcd")
    seen(sea, found, 1.0, {name: five[name] for name in "bd"})
    fresh = {name: five[name] for name in "eac"}
    assert seen(sea, found, TUNING.forget_s + 0.1, fresh) is None
    assert list(found._seen_ns) == list("bdea")
    places = found._state[0, :, :2] * METRE_PX
    assert -places[:, 1] == pytest.approx([20.0, 60.0, 80.0, 0.0])


def test_a_box_beside_the_water_begins_no_robot(sea):
    found = bank()
    level = np.tile(np.eye(3), (1, 1, 1))
    now = BankObservation(0, sea.camera, {"sky": at(0.0, -50.0), "sea": at(0.0, 50.0)})
    found.update(now, 0.0, np.array([[0.0, 0.0, HEIGHT_M]]), level)
    assert list(found._seen_ns) == ["sea"]
    assert found._state[0, 0, 0] == pytest.approx(HEIGHT_M * FOCAL_PX / 50.0, rel=1e-3)


def test_an_error_that_lasts_moves_robots_as_the_camera_does(sea):
    """A compass off by 0.1 rad: over 0.4 m of flight it feigns 4 cm to the side, no more."""
    model = platform()
    model.stationary = lambda _fix: np.diag([0.0] * 5 + [0.01, 0.0])
    model.correlation_time_s = 0.0
    spread = []
    for east in (0.0, 0.4):
        found = bank(1, model)
        for step, place in enumerate((0.0, east)):
            now = BankObservation(round(step * STEP_S * 1e9), sea.camera, {"a": at()})
            position = np.array([[place, 0.0, HEIGHT_M]])
            fit = found.update(now, step * STEP_S, position, DOWN[None])
        spread.append(math.exp(float(fit.size[0])))
    alone = math.sqrt(spread[0])  # the same along both axes
    assert spread[1] == pytest.approx(alone * (alone + (0.1 * 0.4 * METRE_PX) ** 2), rel=1e-3)


def test_boxes_and_poses_noisier_than_stated_have_that_much_more_variance(sea):
    """As if it were stated; so have slow errors of the angles, but not those of the receiver."""

    def found(stated, level):
        model = platform(gnss_white=stated * 0.04)
        model.stationary = lambda _fix: np.diag([0.3, 0.3, 0.1, *[stated * 0.01] * 3, 0.0])
        model.pixel = stated
        own = bank(2, model)
        own.update(BankObservation(0, sea.camera, {"a": at()}), 0.0, CAMERAS, TURNS, level=level)
        now = BankObservation(round(STEP_S * 1e9), sea.camera, {"a": at(30.0)})
        return own.update(now, STEP_S, CAMERAS, TURNS, level=level)

    told, learnt, unknown = found(9.0, 1.0), found(1.0, 9.0), found(1.0, 1.0)
    np.testing.assert_allclose(learnt.squares, told.squares)
    np.testing.assert_allclose(learnt.size, told.size)
    assert (unknown.squares > 1.05 * told.squares).all()


CAMERAS = np.array([[0.0, 0.0, HEIGHT_M], [0.2, 0.0, HEIGHT_M]])
TURNS = np.broadcast_to(DOWN, (2, 3, 3))
