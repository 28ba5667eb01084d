# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Carries a robot's box from one frame to the next: prediction, candidates, decision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.numerics.linear_assignment import linear_sum_assignment
from aerial_gnss_ros.teaching.proposals import Proposals, likeness

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Tuning:
    """Constants of the decision.

    Attributes:
        size: one sigma of the logarithm of a box's change of size in one step.
        extent: the same of its diagonals' since the mark: of a square that turns, up to 0.35.
        unlike: one sigma of 1 - likeness of one object in two images.
        likeness: least likeness of a candidate.
        gate: greatest distance of a candidate from its prediction, sigma.
        nothing: log-likelihood of an object that no candidate shows.
        clutter: share of the pixels round a box that are no water, above which nothing is sure:
            glint and foam look like anything.
        stolen: weight of another track's claim to the same candidate.
        sure: least probability of a label that needs no answer.
        speed: one sigma of an object's speed in the image at its first mark, box lengths a second.
        change: one sigma of its change of speed, box lengths a second squared.
        kept: weight of an object's earlier colours in their average.
        lost: one sigma of the position, share of the image's width, beyond which an object is
            searched no longer.
        edge: share of a box outside the image beyond which the object counts as out of view.
    """

    size: float = 0.45
    extent: float = 0.25
    unlike: float = 0.10
    likeness: float = 0.55
    gate: float = 3.5
    nothing: float = -9.0
    clutter: float = 0.2
    stolen: float = 0.2
    sure: float = 0.8
    speed: float = 0.7
    change: float = 0.5
    kept: float = 0.8
    lost: float = 0.10
    edge: float = 0.5


TUNING = Tuning()


class Sight(Enum):
    """What is known of a robot in a frame."""

    SURE = "sure"
    UNSURE = "unsure"
    LOST = "lost"
    OUT = "out"


@dataclass(frozen=True)
class Track:
    """One robot in one frame, on its way from a mark.

    Attributes:
        frame: index of the frame of whose pixels the rest is.
        box: (4,) centre x, y, width, height, px.
        velocity: (2,) px/s beside the image's own motion.
        variance: of the centre, each axis, px squared.
        marked: (k,) colours at the mark.
        seen: (k,) average of the colours since.
        extent: length of the box's diagonals at the mark, in the units of `plane`: whichever way a
            long robot turns, it stays about the same.
        plane: (2, 2) px of this frame from units of the water, or from px of the mark's frame.
        steps: frames since the mark.
        away_s: time since it was seen, s; once too long (`returned`), it stays so until a mark.
        sight: what is known here.
        probability: of the box, 0 to 1.
    """

    frame: int
    box: Array
    velocity: Array
    variance: float
    marked: Array
    seen: Array
    extent: float
    plane: Array
    steps: int = 0
    away_s: float = 0.0
    sight: Sight = Sight.SURE
    probability: float = 1.0


def started(frame: int, box: Array, look: Array, plane: Array) -> Track:
    """Return the track of a robot in the frame of a mark; arguments as in `Track`."""
    variance = (0.1 * float(box[2:].max())) ** 2
    extent = float(extents(box[None], plane)[0])
    return Track(frame, box.copy(), np.zeros(2), variance, look, look, extent, plane)


def extents(boxes: Array, plane: Array) -> Array:
    """Return the mean lengths (n,) of the diagonals of boxes (n, 4), see `Track.plane`."""
    back = np.linalg.inv(plane)
    both = [np.linalg.norm(boxes[:, 2:] * (1.0, sign) @ back.T, axis=1) for sign in (1.0, -1.0)]
    return np.asarray(0.5 * (both[0] + both[1]))


def turning(track: Track) -> Array:
    """Return the width and height (2,) of what a robot covers as it turns, px."""
    return np.asarray(track.extent * np.linalg.norm(track.plane, axis=1))


def predicted(track: Track, frame: int, moved: Array, sigma: float, elapsed_s: float) -> Track:
    """Return a track in the next frame, before that frame is looked at.

    Args:
        track: in its own frame.
        frame: the next one.
        moved: (3, 2) in the next frame: the centre, displaced by the velocity; the same and 1 px
            to the right; the same and 1 px down.
        sigma: of the motion between the frames, px.
        elapsed_s: time between the frames, without its sign.
    """
    axes = moved[1:] - moved[0]
    scale = float(np.sqrt(abs(np.linalg.det(axes))))
    long = scale * float(track.box[2:].max())
    unknown = TUNING.speed if track.steps == 0 else TUNING.change * elapsed_s
    spread = (unknown * long * elapsed_s) ** 2
    variance = track.variance * scale**2 + spread + sigma**2
    box = np.concatenate([moved[0], track.box[2:] * scale])
    velocity = track.velocity @ axes
    return replace(
        track, frame=frame, box=box, velocity=velocity, variance=variance,
        plane=axes.T @ track.plane, steps=track.steps + 1, away_s=track.away_s + elapsed_s,
    )  # fmt: skip


def likelihoods(track: Track, found: Proposals) -> Array:
    """Return the log-likelihoods (n,) that proposals show a predicted track; -inf: they do not."""
    if not len(found.boxes):
        return np.zeros(0)
    gap = np.linalg.norm(found.boxes[:, :2] - track.box[:2], axis=1)
    # A proposal's middle is that of its pixels, not of the robot: off by a part of its size.
    variance = track.variance + (0.25 * float(track.box[2:].max())) ** 2
    apart = gap**2 / variance
    like = np.maximum(likeness(track.marked, found.looks), likeness(track.seen, found.looks))
    long = found.boxes[:, 2:].max(axis=1)
    grown = np.log(long / track.box[2:].max()) / TUNING.size
    other = np.log(extents(found.boxes, track.plane) / track.extent) / TUNING.extent
    unlike = (1.0 - like) / TUNING.unlike
    value = -0.5 * (apart + grown**2 + other**2 + unlike**2)
    value = value - np.log(np.sqrt(variance) / (0.5 * track.box[2:].max()))
    good = (apart < TUNING.gate**2) & (like > TUNING.likeness)
    return np.where(good, value, -np.inf)


def assigned(values: Array, boxes: Array) -> tuple[NDArray[np.int64], Array]:
    """Return which candidate each track is given (-1: none), and the probabilities (n,).

    Args:
        values: (n tracks, m candidates) log-likelihoods.
        boxes: (m, 4) of the candidates.
    """
    count, candidates = values.shape
    if count == 0:
        return np.zeros(0, dtype=np.int64), np.zeros(0)
    nothing = np.full((count, count), -np.inf)
    np.fill_diagonal(nothing, TUNING.nothing)
    whole = np.hstack([values, nothing])
    rows, columns = linear_sum_assignment(np.where(np.isfinite(whole), -whole, 1e6))
    chosen = np.full(count, -1, dtype=np.int64)
    chosen[rows] = np.where(columns < candidates, columns, -1)
    weights = np.exp(np.minimum(whole, 50.0))
    probability = np.zeros(count)
    for i in np.flatnonzero(chosen >= 0):
        others = np.arange(count) != i
        # What another track explains is no rival, nor is another box of the same object.
        free = ~np.isin(np.arange(candidates), chosen[others]) & ~_same(boxes, chosen[i])
        own, rivals = weights[i, chosen[i]], weights[i, :candidates][free].sum()
        stolen = weights[others, chosen[i]].max(initial=0.0)
        probability[i] = own / (own + rivals + np.exp(TUNING.nothing) + TUNING.stolen * stolen)
    return chosen, probability


def _same(boxes: Array, index: int) -> NDArray[np.bool_]:
    """Return which boxes (n,) may be of the same object as one of them."""
    gap = np.abs(boxes[:, :2] - boxes[index, :2])
    return np.asarray((gap <= 0.5 * np.maximum(boxes[:, 2:], boxes[index, 2:])).all(axis=1))


def updated(track: Track, box: Array, look: Array, probability: float, elapsed_s: float) -> Track:
    """Return a predicted track after its box was found.

    Args:
        track: predicted.
        box: (4,) found.
        look: (k,) its colours.
        probability: of the box.
        elapsed_s: time since the last frame, without its sign.
    """
    long = float(box[2:].max())
    noise = (0.12 * long) ** 2
    gain = track.variance / (track.variance + noise)
    innovation = box[:2] - track.box[:2]
    velocity = track.velocity + 0.4 * gain * innovation / max(elapsed_s, 1e-3)
    most = 1.5 * TUNING.speed * long
    speed = float(np.linalg.norm(velocity))
    if speed > most:
        velocity = velocity * most / speed
    sure = probability >= TUNING.sure and not returned(track)
    kept = TUNING.kept if sure else 1.0
    seen = kept * track.seen + (1.0 - kept) * look
    extent = track.extent**kept * float(extents(box[None], track.plane)[0]) ** (1.0 - kept)
    return replace(
        track,
        box=box,
        extent=extent,
        velocity=velocity,
        away_s=track.away_s if returned(track) else 0.0,
        variance=(1.0 - gain) * track.variance + 1.0,
        seen=seen,
        sight=Sight.SURE if sure else Sight.UNSURE,
        probability=probability if sure else min(probability, 0.5),
    )


def returned(track: Track) -> bool:
    """Return whether a robot was away so long that what is found may be another one.

    It may have moved by more than its own length since it was seen.
    """
    return track.away_s * TUNING.speed > 1.0


def coasted(track: Track, size: tuple[int, int], out: bool = False) -> Track:
    """Return a predicted track that no proposal shows: unsure, out of view or lost.

    Args:
        track: predicted.
        size: width and height of the image, px.
        out: whether it is known to be out of view.
    """
    if out or outside(track.box, size) > TUNING.edge:
        sight = Sight.OUT
    elif np.sqrt(track.variance) > TUNING.lost * size[0]:
        sight = Sight.LOST
    else:
        sight = Sight.UNSURE
    return replace(track, sight=sight, probability=0.0, velocity=0.7 * track.velocity)


def absent(frame: int, like: Track) -> Track:
    """Return the track of a robot that a person does not see in a frame."""
    return replace(like, frame=frame, sight=Sight.OUT, probability=0.0)


def doubted(track: Track) -> Track:
    """Return a track whose box another track claims, too."""
    return replace(track, sight=Sight.UNSURE, probability=0.5)


def outside(box: Array, size: tuple[int, int]) -> float:
    """Return the share of a box's area outside the image."""
    low = np.maximum(box[:2] - box[2:] / 2.0, 0.0)
    high = np.minimum(box[:2] + box[2:] / 2.0, size)
    inside = np.maximum(high - low, 0.0).prod()
    return float(1.0 - inside / max(box[2:].prod(), 1e-9))


def clipped(box: Array, size: tuple[int, int]) -> Array:
    """Return the part of a box inside the image."""
    low = np.clip(box[:2] - box[2:] / 2.0, 0.0, size)
    high = np.clip(box[:2] + box[2:] / 2.0, 0.0, size)
    return np.concatenate([(low + high) / 2.0, high - low])


def overlap(one: Array, other: Array) -> float:
    """Return the intersection over union of two boxes."""
    low = np.maximum(one[:2] - one[2:] / 2.0, other[:2] - other[2:] / 2.0)
    high = np.minimum(one[:2] + one[2:] / 2.0, other[:2] + other[2:] / 2.0)
    both = float(np.maximum(high - low, 0.0).prod())
    return both / max(float(one[2:].prod() + other[2:].prod()) - both, 1e-9)


def best(sights: Sequence[Track]) -> Track:
    """Return what the tracks of one robot from several marks say together in one frame."""
    ranked = sorted(
        sights, key=lambda one: (-one.probability, one.sight is not Sight.OUT, one.steps)
    )
    first = ranked[0]
    for other in ranked[1:]:
        if Sight.SURE is first.sight is other.sight and overlap(first.box, other.box) < 0.2:
            return doubted(first)
    return first
