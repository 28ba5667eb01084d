# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Motion of the image between two frames without telemetry, from what stands out in both.

Waves move and change, so features of the water align badly: whatever floats is matched instead,
by its colours and by one similarity transform that fits most of it (RANSAC: M. Fischler and
R. Bolles, 1981, here over all pairs). With too little in view, phase correlation of the water.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.teaching.proposals import Proposals, likeness

Array = NDArray[np.float64]
Points = NDArray[np.complex128]


@dataclass(frozen=True)
class Tuning:
    """Constants of the alignment.

    Attributes:
        most: number of the strongest proposals that are matched.
        alike: least likeness of two proposals that may be one object.
        near: share of the image's width within which a moved proposal fits one of the next image:
            things drift and swim.
        scales: bounds of the change of size.
        turn: greatest change of direction, rad.
        motion: standard deviation of the shift, share of the image's width: prefers small ones.
        least: least score of a fit: about so many things that fit.
        small_px: width to which images are reduced for the phase correlation.
        response: least response of a usable phase correlation.
        fitted, correlated, unknown: one sigma of the position that a transform of each kind gives,
            share of the image's width.
    """

    most: int = 14
    alike: float = 0.75
    near: float = 0.012
    scales: tuple[float, float] = (0.75, 1.33)
    turn: float = 0.6
    motion: float = 0.15
    least: float = 2.2
    small_px: int = 480
    response: float = 0.3
    fitted: float = 0.006
    correlated: float = 0.01
    unknown: float = 0.05


TUNING = Tuning()


@dataclass(frozen=True)
class Transform:
    """A similarity transform from one image's pixels to another's.

    Attributes:
        matrix: (2, 3).
        sigma: one sigma of moved positions, px.
        how: what it was found from.
    """

    matrix: Array
    sigma: float
    how: str

    def move(self, points: Array) -> Array:
        """Return points (n, 2) in the other image."""
        return np.asarray(points @ self.matrix[:, :2].T + self.matrix[:, 2])

    @property
    def inverse(self) -> Transform:
        """The transform back."""
        back = np.asarray(cv2.invertAffineTransform(self.matrix), dtype=np.float64)
        return Transform(back, self.sigma, self.how)


def small(image: Image) -> NDArray[np.float32]:
    """Return an image as `align` wants it for the phase correlation."""
    width = TUNING.small_px
    height = max(16, round(image.shape[0] * width / image.shape[1]))
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    grey = cv2.resize(grey, (width, height), interpolation=cv2.INTER_AREA).astype(np.float32)
    band: NDArray[np.float32] = cv2.GaussianBlur(grey, (0, 0), 3) - cv2.GaussianBlur(
        grey, (0, 0), 25
    )
    return band


def align(
    first: Proposals,
    second: Proposals,
    width: int,
    smalls: tuple[NDArray[np.float32], NDArray[np.float32]] | None = None,
) -> Transform:
    """Return the motion from the first image to the second.

    Args:
        first: what stands out in the first image.
        second: what stands out in the second.
        width: of the images, px.
        smalls: both images reduced, see `small`; None: no phase correlation.
    """
    fitted = _fit(first, second, width)
    if fitted is not None:
        return Transform(fitted, TUNING.fitted * width, "objects")
    if smalls is not None:
        window = cv2.createHanningWindow(smalls[0].shape[::-1], cv2.CV_32F)
        shift, response = cv2.phaseCorrelate(*smalls, window)
        if response > TUNING.response:
            matrix = np.eye(2, 3)
            matrix[:, 2] = np.array(shift) * width / smalls[0].shape[1]
            return Transform(matrix, TUNING.correlated * width, "water")
    return Transform(np.eye(2, 3), TUNING.unknown * width, "nothing")


def _fit(first: Proposals, second: Proposals, width: int) -> Array | None:
    """Return the similarity (2, 3) that moves most things onto like ones; None if none does.

    Points are complex numbers here: a similarity is q = a p + b.
    """
    p, q = _points(first), _points(second)
    if min(len(p), len(q)) < 2:
        return None
    alike = np.array([likeness(one, second.looks[: len(q)]) for one in first.looks[: len(p)]])
    alike = np.where(alike >= TUNING.alike, (alike - TUNING.alike) / (1.0 - TUNING.alike), 0.0)
    # Hypotheses from all pairs of possible matches.
    i, j = np.nonzero(alike > 0.0)
    one, two = np.triu_indices(len(i), 1)
    one, two = one[i[one] != i[two]], two[i[one] != i[two]]
    ok = j[one] != j[two]
    one, two = one[ok], two[ok]
    dp, dq = p[i[two]] - p[i[one]], q[j[two]] - q[j[one]]
    ok = (np.abs(dp) > 0.03 * width) & (np.abs(dq) > 0.03 * width)
    a = np.divide(dq, dp, out=np.ones_like(dp), where=ok)
    ok &= (np.abs(a) > TUNING.scales[0]) & (np.abs(a) < TUNING.scales[1])
    ok &= np.abs(np.angle(a)) < TUNING.turn
    a, b = a[ok], (q[j[one]] - a * p[i[one]])[ok]
    # Objects may be drawn apart by waves; a pure shift is a hypothesis of each match, too.
    a = np.concatenate([np.ones(len(i)), a])
    b = np.concatenate([q[j] - p[i], b])
    if not len(a):
        return None
    middle = 0.5 * width * (1.0 + 0.5625j)
    shift = np.abs(a * middle + b - middle)
    moved = a[:, None] * p[None] + b[:, None]
    gap = np.abs(moved[:, :, None] - q[None, None, :]) / (TUNING.near * width)
    fit = np.where(gap < 3.0, alike[None] * np.exp(-0.5 * gap**2), 0.0)
    score = fit.max(axis=2).sum(axis=1)
    prior = 0.5 * (shift / (TUNING.motion * width)) ** 2
    prior = prior + 2.0 * np.abs(np.log(np.abs(a))) + 0.5 * np.abs(np.angle(a))
    total = score - 0.3 * np.minimum(prior, 8.0)
    best = int(total.argmax())
    if score[best] < min(TUNING.least, 0.6 * len(p)):
        return None
    return _refined(p, q, fit[best])


def _refined(p: Points, q: Points, fit: Array) -> Array:
    """Return the least-squares similarity (2, 3) of the things that fit."""
    weight, match = fit.max(axis=1), fit.argmax(axis=1)
    use = weight > 0.05
    weight, source, target = weight[use], p[use], q[match[use]]
    total = weight.sum()
    p0, q0 = (weight * source).sum() / total, (weight * target).sum() / total
    spread = (weight * np.abs(source - p0) ** 2).sum()
    a = 1.0 + 0.0j
    if use.sum() >= 2 and spread > 0.0:
        a = (weight * np.conj(source - p0) * (target - q0)).sum() / spread
    b = q0 - a * p0
    return np.array([[a.real, -a.imag, b.real], [a.imag, a.real, b.imag]])


def _points(found: Proposals) -> Points:
    boxes = found.boxes[: TUNING.most]
    return np.asarray(boxes[:, 0] + 1j * boxes[:, 1])
