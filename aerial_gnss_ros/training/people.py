# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Draws people in the water as a drone sees them: wetsuit, perhaps a life jacket, limbs, foam.

The swimmers of the renderers lie stretched out in one colour. People of whom a drone is to keep an
eye stand or sit in the water: a head, a jacket in a rescue colour, arms beside it, legs that fade
with depth, hands and soles brighter than the rest.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]
_FINE = 4  # pixels of the drawing for a pixel of the image
_JACKETS = ((10, 120, 250), (20, 60, 230), (20, 215, 250), (30, 30, 200), (40, 240, 200))
_SUITS = ((50, 42, 38), (30, 26, 24), (85, 62, 40), (70, 68, 66))
_SKINS = ((150, 175, 215), (110, 140, 190), (60, 85, 125), (40, 55, 85))
_HAIR = ((25, 30, 40), (60, 90, 120), (20, 20, 20), (40, 40, 190), (160, 160, 160))


def person(rng: np.random.Generator, length: float) -> tuple[F32, F32]:
    """Return a person about `length` px long.

    Args:
        rng: all randomness.
        length: of head to feet or hand to hand as seen, px.

    Returns:
        Coverage (side, side), 0 to 1, and colours (side, side, 3), blue, green, red.
    """
    side = int(1.4 * length) + 8
    drawn = _Drawing(rng, side, length * _FINE)
    drawn.legs()
    drawn.arms()
    drawn.trunk()
    share = cv2.resize(drawn.share, (side, side), interpolation=cv2.INTER_AREA)
    colours = cv2.resize(drawn.colours, (side, side), interpolation=cv2.INTER_AREA)
    turn = cv2.getRotationMatrix2D((side / 2.0, side / 2.0), float(rng.uniform(0.0, 360.0)), 1.0)
    share = cv2.warpAffine(share, turn, (side, side))
    colours = cv2.warpAffine(colours, turn, (side, side), borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(share, np.float32), np.asarray(colours, np.float32)


class _Drawing:
    """One person, head up.

    Args:
        rng: all randomness.
        side: of the image, px.
        unit: length of the person, fine px.
    """

    def __init__(self, rng: np.random.Generator, side: int, unit: float) -> None:
        self._rng, self._unit = rng, unit
        size = side * _FINE
        self.share = np.zeros((size, size), np.float32)
        self._suit = self._of(_SUITS) if rng.random() < 0.8 else rng.uniform(10.0, 200.0, 3)
        self._skin = self._of(_SKINS)
        self._hand = self._skin if rng.random() < 0.7 else np.full(3, 225.0)
        self.colours = np.tile(self._suit.astype(np.float32), (size, size, 1))
        self._middle = np.full(2, size / 2.0) + np.array([0.0, -0.05 * unit])
        self._wide = unit * rng.uniform(0.10, 0.17)
        self._tall = unit * rng.uniform(0.10, 0.22)

    def _of(self, colours: tuple[tuple[int, int, int], ...]) -> NDArray[np.float64]:
        chosen = np.array(colours[int(self._rng.integers(len(colours)))], dtype=np.float64)
        return np.clip(chosen * self._rng.uniform(0.75, 1.15), 0.0, 255.0)

    def _paint(self, mask: NDArray[np.uint8], colour: NDArray[np.float64], share: float) -> None:
        on = mask > 0
        self.colours[on] = colour
        self.share[on] = np.maximum(self.share[on], share)

    def _line(self, *points: NDArray[np.float64], width: float) -> NDArray[np.uint8]:
        mask = np.zeros(self.share.shape, np.uint8)
        corners = np.round(np.array(points)).astype(np.int32)
        cv2.polylines(mask, [corners], False, 255, max(1, round(width)))
        return mask

    def _oval(
        self, middle: NDArray[np.float64], half: tuple[float, float], turn: float = 0.0,
        width: float = -1.0,
    ) -> NDArray[np.uint8]:  # fmt: skip
        mask = np.zeros(self.share.shape, np.uint8)
        at, axes = np.round(middle).astype(int), np.maximum(1, np.round(half)).astype(int)
        line = -1 if width < 0.0 else max(1, round(width))
        cv2.ellipse(
            mask, (int(at[0]), int(at[1])), (int(axes[0]), int(axes[1])), turn, 0.0, 360.0, 255,
            line,
        )  # fmt: skip
        return mask

    def legs(self) -> None:
        """Draw legs that fade with depth, and soles."""
        rng, unit = self._rng, self._unit
        depth = rng.uniform(0.0, 0.9)  # share that shows
        if depth < 0.15:
            return
        hip = self._middle + np.array([0.0, 0.8 * self._tall])
        for side in (-1.0, 1.0):
            knee = hip + unit * np.array([side * rng.uniform(0.03, 0.2), rng.uniform(0.08, 0.25)])
            foot = knee + unit * np.array([rng.normal(0.0, 0.08), rng.uniform(0.08, 0.25)])
            limb = self._line(hip, knee, foot, width=unit * rng.uniform(0.05, 0.09))
            self._paint(limb, self._suit, depth * 0.8)
            if rng.random() < 0.6:
                sole = self._oval(foot, (unit * 0.05, unit * 0.03), rng.uniform(0.0, 180.0))
                self._paint(sole, self._hand, depth)

    def arms(self) -> None:
        """Draw arms spread beside the trunk, and hands."""
        rng, unit = self._rng, self._unit
        for side in (-1.0, 1.0):
            shoulder = self._middle + np.array([side * self._wide, -0.6 * self._tall])
            reach = unit * rng.uniform(0.08, 0.24)
            angle = rng.uniform(-1.2, 1.2)
            elbow = shoulder + reach * np.array([side * np.cos(angle), np.sin(angle)])
            angle += rng.normal(0.0, 0.9)
            hand = elbow + reach * np.array([side * np.cos(angle), np.sin(angle)])
            shown = rng.uniform(0.35, 1.0)
            limb = self._line(shoulder, elbow, hand, width=unit * rng.uniform(0.04, 0.07))
            self._paint(limb, self._suit, shown)
            self._paint(self._oval(hand, (unit * 0.035, unit * 0.035)), self._hand, shown)

    def trunk(self) -> None:
        """Draw trunk, jacket or ring, and head."""
        rng, unit, middle = self._rng, self._unit, self._middle
        self._paint(self._oval(middle, (self._wide, self._tall)), self._suit, 1.0)
        jacket = self._of(_JACKETS)
        kind = rng.random()
        if kind < 0.45:  # a jacket: all of the chest, or open in front
            at = middle - np.array([0.0, 0.3 * self._tall])
            scale = rng.uniform(0.7, 1.25)
            half = (self._wide * scale, self._tall * rng.uniform(0.45, 0.9))
            self._paint(self._oval(at, half), jacket, 1.0)
            if rng.random() < 0.6:
                gap = self._oval(
                    at + np.array([0.0, 0.3 * half[1]]), (0.35 * half[0], 0.75 * half[1])
                )
                second = self._of(_JACKETS) if rng.random() < 0.5 else self._suit
                self._paint(gap, second, 1.0)
        elif kind < 0.6:  # a ring or a float held in front
            at = middle + self._tall * rng.normal(0.0, 0.5, 2)
            half = (unit * rng.uniform(0.1, 0.2), unit * rng.uniform(0.06, 0.16))
            hollow = float(unit * 0.05) if rng.random() < 0.5 else -1.0
            self._paint(self._oval(at, half, rng.uniform(0.0, 180.0), hollow), jacket, 1.0)
        at = middle - np.array([rng.normal(0.0, 0.02) * unit, self._tall + 0.02 * unit])
        radius = unit * rng.uniform(0.05, 0.08)
        self._paint(self._oval(at, (radius, 1.15 * radius)), self._of(_HAIR), 1.0)
        if rng.random() < 0.6:
            face = at + radius * rng.normal(0.0, 0.4, 2)
            self._paint(self._oval(face, (0.6 * radius, 0.6 * radius)), self._skin, 1.0)
