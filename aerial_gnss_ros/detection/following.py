# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Prediction of boxes in the next image with constant velocity in pixels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.pieces import Piece

_GROWTH_PX = 24.0  # additional margin for each image in which a box was missed
_SMOOTHING = 0.5  # share of the newest displacement in the velocity
_SURE = 3  # detections after which a box is confirmed and not a wave
_PATIENCE = 2  # images without it after which a box is lost
_PATIENCE_IF_SURE = 10  # the network does not find a faint robot in every image


@dataclass
class Followed:
    """One followed box.

    Attributes:
        corners: (4,) left, top, right, bottom in the image now, px.
        velocity: (2,) px an image.
        class_id: index of the class.
        sightings: number of images in which it was detected.
        missed: number of consecutive images in which it was not.
        cut: whether the edge of a window truncates it.
    """

    corners: NDArray[np.float64]
    velocity: NDArray[np.float64]
    class_id: int
    sightings: int = 1
    missed: int = 0
    cut: bool = False

    @property
    def sure(self) -> bool:
        """Whether it is confirmed, so that it is searched for when missed."""
        return self.sightings >= _SURE

    @property
    def lost(self) -> bool:
        """Whether it is no longer searched for."""
        return self.missed >= (_PATIENCE_IF_SURE if self.sure else _PATIENCE)

    @property
    def middle(self) -> NDArray[np.float64]:
        """(2,) px."""
        half: NDArray[np.float64] = (self.corners[:2] + self.corners[2:]) / 2
        return half

    def reach(self, margin: float) -> float:
        """Return the search margin beyond its corners, px."""
        longest = float((self.corners[2:] - self.corners[:2]).max())
        speed = float(np.abs(self.velocity).max())
        more = longest if self.cut else 0.0  # its extent beyond the edge is unknown
        return margin + more + 0.5 * speed + _GROWTH_PX * min(self.missed, _PATIENCE)


class Follower:
    """Follows boxes from image to image.

    Args:
        margin: search margin around a box, px.
    """

    def __init__(self, margin: float) -> None:
        self._margin = margin
        self.followed: list[Followed] = []

    def forget(self) -> None:
        """Drop all boxes."""
        self.followed = []

    @property
    def blind(self) -> bool:
        """Whether none of the boxes was detected in the last image."""
        return all(box.missed for box in self.followed)

    def predict(self, size: tuple[int, int]) -> NDArray[np.float64]:
        """Predict all boxes in the next image; return their search regions (n, 4), px.

        Those that leave the image are dropped.
        """
        for box in self.followed:
            box.corners = box.corners + np.tile(box.velocity, 2)
        self.followed = [
            box for box in self.followed if (box.middle > 0.0).all() and (box.middle < size).all()
        ]
        reach = np.array([box.reach(self._margin) for box in self.followed])
        corners = np.array([box.corners for box in self.followed]).reshape(-1, 4)
        likely: NDArray[np.float64] = corners + reach[:, None] * np.array([-1.0, -1.0, 1.0, 1.0])
        return likely

    def update(self, found: Sequence[Piece]) -> bool:
        """Update with an image's detections; return whether a confirmed box is newly missed."""
        pairs = self._pairs(found)
        moved = [self._see(self.followed[i], found[j]) for i, j in pairs.items()]
        for i, box in enumerate(self.followed):
            box.missed += i not in pairs
        missed = any(box.sure and box.missed == _PATIENCE for box in self.followed)
        self.followed = [box for box in self.followed if not box.lost]
        # New boxes get the others' motion, which is mostly the camera's rotation.
        common = np.median(moved, axis=0) if moved else np.zeros(2)
        taken = set(pairs.values())
        self.followed += [
            Followed(piece.corners, common.copy(), piece.class_id, cut=not piece.whole)
            for j, piece in enumerate(found)
            if j not in taken
        ]
        return missed

    def _pairs(self, found: Sequence[Piece]) -> dict[int, int]:
        """Return pairs of followed and detected boxes: nearest first, each once."""
        if not self.followed or not found:
            return {}
        middles = np.array([(p.corners[:2] + p.corners[2:]) / 2 for p in found])
        here = np.array([box.middle for box in self.followed])
        apart = np.linalg.norm(here[:, None] - middles[None], axis=2)
        reach = np.array([box.reach(self._margin) for box in self.followed])
        apart[apart > reach[:, None]] = np.inf
        pairs: dict[int, int] = {}
        for flat in np.argsort(apart, axis=None, kind="stable"):
            i, j = divmod(int(flat), len(found))
            if not np.isfinite(apart[i, j]):
                break
            if i not in pairs and j not in pairs.values():
                pairs[i] = j
        return pairs

    @staticmethod
    def _see(box: Followed, piece: Piece) -> NDArray[np.float64]:
        """Move a box to its detection; return its velocity."""
        off = (piece.corners[:2] + piece.corners[2:]) / 2 - box.middle
        if not box.cut and piece.whole:  # the centre of a truncated box is not the robot's
            gain = 1.0 if box.sightings == 1 else _SMOOTHING
            box.velocity = box.velocity + gain * off / (1 + box.missed)
        box.corners, box.cut = piece.corners, not piece.whole
        box.class_id, box.missed = piece.class_id, 0
        box.sightings += 1
        return box.velocity
