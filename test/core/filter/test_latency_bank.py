# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Filters for each latency, under a camera that looks down: numbers checked by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.estimation.snapshot import Plans, Snapshot
from aerial_gnss_ros.core.filter import latency_bank
from aerial_gnss_ros.core.filter.latency_bank import (
    HYPOTHESES,
    TUNING,
    BankObservation,
    LatencyBank,
    NoiseHypothesis,
)
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.models.motion_model import MotionModel

HEIGHT_M, FOCAL_PX, STEP_S = 18.0, 900.0, 0.5
METRE_PX = FOCAL_PX / HEIGHT_M
DOWN = matrix_from_rpy(0.0, 0.5 * math.pi, 0.0)
SPEED = 0.4


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
    return LatencyBank(model or platform(), MotionModel(0.0, SPEED), count)


def seen(sea, found, t, pixels, east=(0.0,), fix=None, looks=DOWN, anew=None):
    """Show an image with boxes by name to a bank whose cameras are so far east, m."""
    now = BankObservation(
        round(t * 1e9), sea.camera, {name: np.array(one) for name, one in pixels.items()}, fix
    )
    positions = np.array([[one, 0.0, HEIGHT_M] for one in east])
    turns = np.broadcast_to(looks, (len(east), 3, 3))
    return found.update(now, STEP_S if t else 0.0, positions, turns, anew)


def expected(white=0.0, slow=0.0):
    """Return the variance of a box in the second image under each hypothesis (k,), px².

    A slow error of the receiver moves camera and robot alike: only its change shows.
    """
    found = []
    for level, lasts_s, box_lasts_s, turns in HYPOTHESES:
        swum = (SPEED * STEP_S) ** 2 + turns**2 * STEP_S**3 / 3.0
        kept = math.exp(-STEP_S / (lasts_s or 60.0))
        box_kept = math.exp(-STEP_S / box_lasts_s) if box_lasts_s else 0.0
        box = (1.0 - box_kept) ** 2 + 1.0 - box_kept**2 + TUNING.box_white
        changed = (1.0 - kept) ** 2 + 1.0 - kept**2
        pose = METRE_PX**2 * (2.0 * white + changed * slow)
        found.append(level * (box + pose) + METRE_PX**2 * swum)
    return np.array(found)


def cost(distance, spread):
    """Return -2 log likelihood of a box so far off, px, in the mean over hypotheses."""
    misfit = 6.0 * np.log1p(distance**2 / spread / 4.0) - 2.0
    return -2.0 * math.log(np.mean(np.exp(-0.5 * (misfit + 2.0 * np.log(spread)))))


@pytest.mark.parametrize(("white", "slow"), [(0.0, 0.0), (0.25, 0.0), (0.0, 4.0)])
@pytest.mark.parametrize("distance", [0.0, 10.0, 60.0, 400.0])
def test_a_box_costs_what_it_does_in_the_mean_over_hypotheses(sea, white, slow, distance):
    found, spread = bank(model=platform(white, slow)), expected(white, slow)
    assert seen(sea, found, 0.0, {"a": at()}) is None
    fit = seen(sea, found, STEP_S, {"a": at(distance)})
    assert fit.misfit + fit.size == pytest.approx([cost(distance, spread)])
    assert fit.count == 1
    assert sum(fit.of_a_robot) == pytest.approx(fit.misfit + fit.size)


def test_the_fix_says_itself_how_far_its_slow_errors_go(sea):
    found = bank()
    seen(sea, found, 0.0, {"a": at()}, fix=np.array([9.0, 9.0]))
    fit = seen(sea, found, STEP_S, {"a": at()}, fix=np.array([9.0, 9.0]))
    assert fit.misfit + fit.size == pytest.approx([cost(0.0, expected(slow=9.0))])


def test_hypotheses_count_by_how_well_they_predicted_the_images_so_far(sea):
    """Boxes 30 px off, then the same again: the second costs what the likelier ones expect."""
    found = bank(model=platform(0.25))
    for step in range(3):
        fit = seen(sea, found, STEP_S * step, {"a": at(30.0 * (step % 2))})
    spread = expected(0.25)
    likely = 0.5 * (-6.0 * np.log1p(900.0 / spread / 4.0) - 2.0 * np.log(spread))
    odds = np.exp(found._odds[0] - found._odds[0].max())
    assert np.argmax(likely) == np.argmax(odds)
    assert fit.size[0] > np.log(spread.min()) * 2.0


def test_what_robots_have_in_common_says_nothing_of_them(sea):
    """All boxes of an image 40 px to the right: a gust, or four robots that swim as one."""
    alone, together = bank(model=platform(1.0)), bank(model=platform(1.0))
    some = {"a": 0.0, "b": 100.0, "c": -100.0}
    for t, off in ((0.0, 0.0), (STEP_S, 40.0)):
        one = seen(sea, alone, t, {"a": at(off)})
        all_three = seen(sea, together, t, {name: at(x + off) for name, x in some.items()})
    apart = bank(model=platform(1.0))
    seen(sea, apart, 0.0, {name: at(x) for name, x in some.items()})
    unlike = {"a": at(40.0), "b": at(60.0), "c": at(-100.0, 40.0)}
    in_part = seen(sea, apart, STEP_S, unlike)
    assert all_three.misfit[0] < one.misfit[0] + 1.0
    assert all_three.of_a_robot[0] == pytest.approx(all_three.misfit / 3.0)
    assert in_part.misfit[0] + in_part.size[0] > all_three.misfit[0] + all_three.size[0] + 2.0


def test_a_robot_is_expected_to_go_on_as_it_moves(sea):
    costs = []
    for pixels in (16.0, 8.0, 0.0):
        found = bank()
        for t, right in ((0.0, 0.0), (STEP_S, 8.0), (2.0 * STEP_S, pixels)):
            fit = seen(sea, found, t, {"a": at(right)})
        costs.append(float(fit.misfit[0] + fit.size[0]))
    assert costs[0] < costs[1] < costs[2]


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
        total += 0.0 if fit is None else fit.misfit + fit.size
    assert np.argmin(total) == 2
    assert np.sort(total)[1] - total[2] > 20.0


def test_each_latency_has_a_robot_where_its_camera_shows_it(sea):
    """Two cameras 3 m apart, and a box one metre right of the middle of both."""
    found = bank(2)
    assert found.places() == {}
    for t in (0.0, STEP_S):
        seen(sea, found, t, {"a": at(), "b": at(METRE_PX)}, (1.0, 4.0))
    places = found.places()
    assert sorted(places) == ["a", "b"]
    np.testing.assert_allclose(places["a"], [[1.0, 0.0], [4.0, 0.0]], atol=1e-6)
    np.testing.assert_allclose(places["b"], [[1.0, -1.0], [4.0, -1.0]], atol=1e-6)


def test_a_latency_that_puts_a_robot_behind_the_camera_is_unlikely(sea):
    found = bank(2)
    seen(sea, found, 0.0, {"a": at()}, (0.0, 0.0))
    fit = seen(sea, found, STEP_S, {"a": at()}, (0.0, 0.0), looks=np.array([DOWN, DOWN.T]))
    assert fit.misfit[1] == pytest.approx(TUNING.out_of_view_cost, abs=2.0)
    assert fit.misfit[0] + fit.size[0] == pytest.approx(cost(0.0, expected()))


def test_what_jumps_far_costs_once(sea):
    """Like a box that was assigned to another robot; from then on it stays where it is."""
    found = bank()
    costs = []
    for step, right in enumerate((0.0, 0.0, 500.0, 500.0)):
        fit = seen(sea, found, STEP_S * step, {"a": at(right)})
        costs.append(0.0 if fit is None else float(fit.misfit[0]))
    assert costs[2] > 20.0
    assert costs[3] < 1.0


def test_where_telemetry_jumps_robots_begin_anew_at_their_boxes(sea):
    """The first candidate begins anew with the second image; the third tells it nothing else."""
    found, anew = bank(2), np.array([True, False])
    seen(sea, found, 0.0, {"a": at()}, (0.0, 0.0))
    seen(sea, found, STEP_S, {"a": at(30.0)}, (0.0, 0.0), anew=anew)
    fit = seen(sea, found, 2.0 * STEP_S, {"a": at(60.0)}, (0.0, 0.0))
    first = bank()
    seen(sea, first, 0.0, {"a": at(30.0)})
    alone = seen(sea, first, STEP_S, {"a": at(60.0)})
    assert fit.misfit[0] == pytest.approx(alone.misfit[0], abs=0.5)
    assert fit.misfit[1] < fit.misfit[0]  # this one has learnt that the robot swims


def test_robots_long_unseen_begin_anew_and_no_more_than_four_are_followed(sea):
    found = bank()
    five = {name: at(20.0 * i) for i, name in enumerate("abcde")}
    seen(sea, found, 0.0, five)
    assert list(found._seen_ns) == list("abcd")
    seen(sea, found, 1.0, {name: five[name] for name in "bd"})
    fresh = {name: five[name] for name in "eac"}
    assert seen(sea, found, TUNING.forget_s + 0.1, fresh) is None
    assert list(found._seen_ns) == list("bdea")
    places = found._state[0].robots[0, :, :2] * METRE_PX
    assert -places[:, 1] == pytest.approx([20.0, 60.0, 80.0, 0.0])


def test_an_image_that_failed_is_undone_by_a_snapshot(sea):
    """It shares the state, which an image therefore never changes in place."""
    found, fits = bank(2), []
    for step in range(2):
        seen(sea, found, STEP_S * step, {"a": at(), "b": at(90.0)}, (0.0, 1.0))
    before = Snapshot((found,), Plans((SimpleNamespace,)))
    for _ in range(2):
        moved = {"a": at(40.0), "b": at(130.0)}
        fits.append(seen(sea, found, 2.0 * STEP_S, moved, (0.0, 1.0), anew=np.array([True, False])))
        before.restore()
    np.testing.assert_array_equal(fits[0].misfit, fits[1].misfit)
    np.testing.assert_array_equal(fits[0].size, fits[1].size)


def test_a_box_beside_the_water_begins_no_robot(sea):
    found = bank()
    level = np.tile(np.eye(3), (1, 1, 1))
    now = BankObservation(0, sea.camera, {"sky": at(0.0, -50.0), "sea": at(0.0, 50.0)})
    found.update(now, 0.0, np.array([[0.0, 0.0, HEIGHT_M]]), level)
    assert list(found._seen_ns) == ["sea"]
    assert found._state[0].robots[0, 0, 0] == pytest.approx(HEIGHT_M * FOCAL_PX / 50.0, rel=1e-3)


def test_poses_between_samples_are_less_certain_by_as_much(sea):
    """As if it were white noise."""
    costs = []
    for model, more in ((platform(0.25), None), (platform(), np.array([[0.25, 0.25, 0, 0, 0, 0]]))):
        found = bank(1, model)
        for step in range(2):
            now = BankObservation(round(step * STEP_S * 1e9), sea.camera, {"a": at(20.0 * step)})
            position = np.array([[0.0, 0.0, HEIGHT_M]])
            fit = found.update(now, step * STEP_S, position, DOWN[None], None, more)
        costs.append(float(fit.misfit[0] + fit.size[0]))
    assert costs[0] == pytest.approx(costs[1])


def test_boxes_whose_errors_last_are_a_constant_place_and_a_decaying_error(sea, monkeypatch):
    """Against the joint Gaussian of three boxes of a robot that stays: 0.5 s apart, for 1.5 s."""
    alone = (NoiseHypothesis(box_lasts_s=TUNING.box_lasts_s),)
    monkeypatch.setattr(latency_bank, "HYPOTHESES", alone)
    found = LatencyBank(platform(), MotionModel(0.0, 1e-6), 1)
    right, times = np.array([0.0, 0.6, 0.9]), STEP_S * np.arange(3)
    fits = [seen(sea, found, t, {"a": at(x)}) for t, x in zip(times, right, strict=True)]
    apart = np.abs(times[:, None] - times)
    errors = np.exp(-apart / TUNING.box_lasts_s) + TUNING.box_white * np.diag([0.0, 1.0, 1.0])
    since = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])  # the place itself may be anywhere
    moved, spread = since @ right, since @ errors @ since.T
    gain = spread[1, 0] / spread[0, 0]
    squares = [moved[0] ** 2 / spread[0, 0]]
    variance = spread[1, 1] - gain * spread[0, 1]
    squares.append((moved[1] - gain * moved[0]) ** 2 / variance)
    costs = [6.0 * math.log1p(one / 4.0) - 2.0 for one in squares]
    assert [float(one.misfit[0]) for one in fits[1:]] == pytest.approx(costs, abs=1e-4)
    assert float(fits[2].size[0]) == pytest.approx(2.0 * math.log(variance), abs=1e-4)


def test_slow_errors_turn_the_camera_about_its_level_axes():
    axes, by_white = matrix_from_rpy(0.1, 0.2, 0.7), np.arange(24.0).reshape(2, 2, 6)
    errors = np.array([0.1, -0.2, 0.3, 0.01, 0.02, -0.03])
    by_slow = latency_bank._common(by_white, axes)[..., :6]
    turned = np.concatenate([errors[:3], axes @ errors[3:]])
    np.testing.assert_allclose(by_slow @ errors, by_white @ turned)
