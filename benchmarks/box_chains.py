# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which boxes of successive images show one object: told by the images alone, without telemetry.

From one image to the next all boxes shift alike but for parallax and their own motion. The shift is
that under which most boxes meet one of their class; each box then continues the chain of the one it
meets. Where two could be meant, or none is, the chain ends: a chain is one object, but an object
may be several chains.
"""

from __future__ import annotations

from itertools import groupby

import numpy as np
from numpy.typing import NDArray

Key = tuple[int, float, float]
Box = tuple[Key, str]
Array = NDArray[np.float64]

NEAR_PX = 60.0
"""Boxes that are nearer to each other than this after the shift show one object, px."""
CLEAR = 2.5
"""The next best is farther by this factor, else nobody can tell."""
LONGEST_S = 1.1
"""Images farther apart are not compared, s."""


def chains(boxes: list[Box]) -> list[list[Box]]:
    """Return the boxes of each object while it stays in view.

    Args:
        boxes: stamp (ns), centre (px) and class, in the order of stamps.
    """
    images = [list(group) for _, group in groupby(boxes, key=lambda box: box[0][0])]
    done: list[list[Box]] = []
    open_: dict[Key, list[Box]] = {}
    before: list[Box] = []
    for image in images:
        near = bool(before) and (image[0][0][0] - before[0][0][0]) * 1e-9 < LONGEST_S
        links = linked(before, image) if near else {}
        continued: dict[Key, list[Box]] = {}
        for place, box in enumerate(image):
            earlier = links.get(place)
            chain = open_.pop(before[earlier][0]) if earlier is not None else []
            continued[box[0]] = [*chain, box]
        done += list(open_.values())
        open_, before = continued, image
    return done + list(open_.values())


def linked(before: list[Box], now: list[Box]) -> dict[int, int]:
    """Return for boxes of an image those of the image before that show the same object."""
    same = np.array([[a[1] == b[1] for b in before] for a in now])
    apart = np.array([[np.subtract(a[0][1:], b[0][1:]) for b in before] for a in now])
    shifts = apart[same]
    if not len(shifts):
        return {}
    counts = [_meeting(apart - shift, same) for shift in shifts]
    best = shifts[max(range(len(counts)), key=counts.__getitem__)]
    distance = np.where(same, np.linalg.norm(apart - best, axis=2), np.inf)
    found = {}
    for row, column in zip(*np.nonzero(distance < NEAR_PX), strict=True):
        rest = [*np.delete(distance[row], column), *np.delete(distance[:, column], row)]
        if min(rest, default=np.inf) > CLEAR * max(distance[row, column], 1.0):
            found[int(row)] = int(column)
    return found


def _meeting(apart: Array, same: NDArray[np.bool_]) -> tuple[int, float]:
    """Return how many boxes meet one of their class, and how closely: more is better."""
    distance = np.where(same, np.linalg.norm(apart, axis=2), np.inf).min(axis=1)
    near = distance < NEAR_PX
    return int(near.sum()), -float(distance[near].sum())
