# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Examples of a taught network: classes of what stands out, equal weights of classes."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.detection.taught import TERMS
from aerial_gnss_ros.training.cut_paste import cut_out
from aerial_gnss_ros.training.labelled import LabelledImage, Truth
from aerial_gnss_ros.training.taught_examples import examples_of, varied, with_things

PLACES = {(60, 60): (40, 40, 230), (200, 60): (40, 220, 230), (60, 160): (240, 240, 240)}
"""Left and top of a red, a yellow and a white box of 40 x 20 px; the white one is no robot."""


@pytest.fixture(name="frame")
def _frame():
    noise = np.random.default_rng(2).normal(0.0, 2.0, (240, 320, 1))
    image = np.clip(np.array([110.0, 120.0, 90.0]) + noise, 0, 255).astype(np.uint8)
    for (left, top), colour in PLACES.items():
        cv2.rectangle(image, (left, top), (left + 39, top + 19), colour, -1)
    corners = np.array([(59.5, 59.5, 99.5, 79.5), (199.5, 59.5, 239.5, 79.5)])
    truth = Truth(corners, np.ones(2, bool), np.full(2, 40.0), np.ones(2), np.array([1, 0]))
    return image, truth


def test_each_box_has_its_class(frame):
    found = examples_of([frame], [], TERMS, 2)
    colours = found.proposals.views[:, 40, 40, :3].astype(int)  # the middle of the near view
    ((blue, green, red),) = colours[found.wanted[:, 1] > 0]
    assert (red > 200, green < 100, blue < 100) == (True, True, True)
    ((blue, green, red),) = colours[found.wanted[:, 0] > 0]
    assert (red > 200, green > 200, blue < 100) == (True, True, True)
    assert found.wanted.sum(axis=0).tolist() == [1, 1]
    assert len(found.wanted) > 2  # the white box, too
    assert (found.proposals.is_robot == (found.wanted.sum(axis=1) > 0)).all()


@pytest.mark.parametrize(
    ("right", "fits"),
    [(99.5, 1.0), (119.5, 1.0), (138.5, 0.69), (159.5, 0.33), (199.5, 0.0)],
)
def test_a_larger_box_fits_its_robot_less(frame, right, fits):
    """The label of the red box reaches further to the right than what is seen of it."""
    image, truth = frame
    wide = Truth(
        np.array([(59.5, 59.5, right, 79.5)]), *(getattr(truth, name)[:1] for name in
        ("counted", "long_px", "contrast", "class_ids")),
    )  # fmt: skip
    found = examples_of([(image, wide)], [], TERMS, 2)
    assert found.wanted.sum(axis=0) == pytest.approx([0.0, fits], abs=0.03)
    assert found.proposals.is_robot.any() == (fits > 0.5)


def test_rare_classes_weigh_as_much_as_frequent_ones(frame):
    image, truth = frame
    one = Truth(*(getattr(truth, name)[:1] for name in
                  ("corners", "counted", "long_px", "contrast", "class_ids")))  # fmt: skip
    found = examples_of([frame, (image, one), (image, one)], [], TERMS, 2)
    totals = found.proposals.weights @ found.wanted
    assert found.wanted.sum(axis=0).tolist() == [1, 3]
    assert totals[0] == pytest.approx(totals[1])
    seen, made = examples_of([frame], [], TERMS, 2), examples_of([], [frame], TERMS, 2)
    assert seen.proposals.weights.sum() == pytest.approx(3.0 * made.proposals.weights.sum())


def test_variants_are_on_all_waters_and_have_more_robots(frame):
    image, truth = frame
    empty = Truth(*(np.zeros(shape) for shape in ((0, 4), 0, 0, 0, 0)))
    waters = [LabelledImage(str(i), empty, lambda i=i: np.full_like(image, 90 + i))
              for i in range(4)]  # fmt: skip
    robots = cut_out(image, truth)
    rng = np.random.default_rng(1)
    made = list(varied(rng, waters, robots, 2, 6))
    assert [np.median(one[..., 0]) for one, _ in made] == [90, 92]
    assert all(len(labels.corners) >= 2 for _, labels in made)
    assert set(np.concatenate([labels.class_ids for _, labels in made])) == {0, 1}
    again = [np.median(one[..., 0]) for one, _ in varied(rng, waters, robots, 6, 1)]
    assert again == [90, 91, 92, 93, 90, 91]
    assert list(varied(rng, waters, [], 5, 6)) == []


def test_other_things_are_drawn_beside_the_robots_and_are_none(frame):
    image, truth = frame
    made, labels = with_things(np.random.default_rng(3), frame)
    assert labels is truth
    for left, top, right, bottom in np.round(truth.corners).astype(int):
        robot = slice(top + 1, bottom), slice(left + 1, right)
        np.testing.assert_array_equal(made[robot], image[robot])
    changed = np.abs(made.astype(int) - image).max(axis=2) > 20
    assert 0.01 < changed.mean() < 0.5
    seen, more = examples_of([frame], [], TERMS, 2), examples_of([(made, truth)], [], TERMS, 2)
    assert more.proposals.is_robot.sum() == seen.proposals.is_robot.sum()
    others = [(one.wanted.sum(axis=1) == 0).sum() for one in (seen, more)]
    assert others[1] >= others[0] + 5


def test_water_without_robots_stays_as_it_is(frame):
    """What is there is real; there is no robot to say how long things are."""
    image, _ = frame
    empty = Truth(*(np.zeros(shape) for shape in ((0, 4), 0, 0, 0, 0)))
    assert with_things(np.random.default_rng(1), (image, empty))[0] is image
