# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a taught network learns from: what stands out in labelled images, with its class."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.second_look_terms import Terms, traits
from aerial_gnss_ros.detection.taught import Proposer
from aerial_gnss_ros.detection.views import views
from aerial_gnss_ros.detection.yolo import iou
from aerial_gnss_ros.training.clutter import Numbers, add_things, pictures
from aerial_gnss_ros.training.cut_paste import Cutout, pasted
from aerial_gnss_ros.training.labelled import LabelledImage, Truth
from aerial_gnss_ros.training.proposals import ROOM, Proposals, joined
from aerial_gnss_ros.training.score import MATCH_IOU

Frame = tuple[Image, Truth]
_REAL = 3.0  # weight of what was seen against what was pasted
_FITS = (0.3, 0.6)
"""Overlap (intersection over union) up to which a box is no robot, and from which it is one.
Between them it is partly one, so that of several boxes on a robot the tightest scores best."""
_THINGS = Numbers(things=4.0, people=4.0, figures=16.0)
_LENGTHS = np.array([1.0 / 3.0, 3.0])  # of these things, lengths of the robots


@dataclass(frozen=True)
class Examples:
    """Boxes with their classes.

    Attributes:
        proposals: the boxes; those of rare classes weigh as much as those of frequent ones.
        wanted: (n, k) how well a box fits a robot of each class, 0 to 1.
    """

    proposals: Proposals
    wanted: NDArray[np.float32]


def examples_of(
    images: Iterable[Frame], variants: Iterable[Frame], terms: Terms, classes: int
) -> Examples:
    """Return the examples of labelled images, and of variants made of them.

    Args:
        images: in which every robot is labelled; each is needed only once.
        variants: the same, less weighted.
        terms: of the network.
        classes: how many there are.
    """
    proposer = Proposer(terms)
    seen = [_of(proposer, frame, terms, classes) for frame in images]
    made = [_of(proposer, frame, terms, classes) for frame in variants]
    both = joined([*(one.times(_REAL) for one, _ in seen), *(one for one, _ in made)])
    wanted = np.concatenate([fits for _, fits in (*seen, *made)])
    weights = both.weights.copy()
    own = [both.is_robot & (fits > 0.0) for fits in wanted.T]
    totals = [weights[chosen].sum() for chosen in own]
    for chosen, total in zip(own, totals, strict=True):
        if total > 0.0:
            weights[chosen] *= sum(totals) / total
    return Examples(Proposals(both.views, both.traits, both.scores, both.is_robot, weights), wanted)


def varied(
    rng: np.random.Generator,
    waters: Sequence[LabelledImage],
    robots: Sequence[Cutout],
    count: int,
    each: int,
) -> Iterator[Frame]:
    """Yield images of water with robots pasted, and other things drawn, into them.

    Args:
        rng: all randomness.
        waters: to paste on, taken in turn.
        robots: cut out.
        count: of images.
        each: robots an image at most.
    """
    for number in range(count if robots else 0):
        water = waters[
            number * len(waters) // count if count < len(waters) else number % len(waters)
        ]
        yield with_things(rng, pasted(rng, water.read(), water.truth, robots, each))


def with_things(rng: np.random.Generator, frame: Frame) -> Frame:
    """Return an image with robots, and with things drawn into it that are none.

    A recording shows little besides its robots and its water. Without these things, whatever else
    floats on other water is as likely taken for a robot as not.

    Args:
        rng: all randomness.
        frame: the image and its labels, which stay.
    """
    image, truth = frame
    if not len(truth.corners):
        return frame
    length = float(np.median((truth.corners[:, 2:] - truth.corners[:, :2]).max(axis=1)))
    least, most = _LENGTHS * length
    paints = pictures(image, truth.corners)
    return add_things(rng, image, truth.corners, _THINGS, paints, (), (least, most)), truth


def _of(
    proposer: Proposer, frame: Frame, terms: Terms, classes: int
) -> tuple[Proposals, NDArray[np.float32]]:
    """Return what stands out in an image, and how well each box fits robots (n, classes)."""
    image, truth = frame
    found = proposer.detect(image)
    overlaps = iou(found.xyxy, truth.corners)
    best = overlaps.max(axis=1, initial=0.0)
    wanted = np.zeros((len(found), classes), dtype=np.float32)
    if len(truth.corners):
        kinds = truth.class_ids[overlaps.argmax(axis=1)]
        low, high = _FITS
        wanted[np.arange(len(found)), kinds] = np.clip((best - low) / (high - low), 0.0, 1.0)
    own = Proposals(
        views(image, found.xywh, terms, ROOM), traits(found.xywh, found.scores), found.scores,
        best >= MATCH_IOU, np.ones(len(found)),
    )  # fmt: skip
    return own, wanted
