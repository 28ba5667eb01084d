# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Measurement update of the joint state with one image's pixels.

Predictions are exact; where derivatives by the platform's errors are taken is decided in
`linearization`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dtrsm
from scipy.linalg.lapack import dpotrf

from aerial_gnss_ros.core.filter.linearization import CameraView, relinearize
from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.filter.predicted_pixels import Linear, linearise
from aerial_gnss_ros.core.filter.reinitialization import reinitialize_lost
from aerial_gnss_ros.core.filter.state import JointState, of_robots
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.models.evidence import SURE_SIGMAS
from aerial_gnss_ros.core.models.platform_model import COUNT, LATENCY, PlatformModel
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis

Array = NDArray[np.float64]


@dataclass(frozen=True)
class UpdateTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    huber_planar: float = 2.8
    """Normalised planar residual beyond which a box is down-weighted (Huber): 2 % of the good ones,
    from exp(-2.8²/2) = 0.02."""
    relinearise_share: float = 0.02
    """Correction of a robot's position, as a share of its distance, from which the update is
    iterated. Judged."""
    max_iterations: int = 3
    """Greatest number of iterations of one update. Judged."""


TUNING = UpdateTuning()


Some = Indices | slice
"""Index of some robots of a joint state."""


def correct(
    joint: JointState,
    slots: Indices,
    pixels: Array,
    sight: CameraView,
    model: PlatformModel,
    fastest: float = np.inf,
    level: float = 1.0,
    alone: bool = False,
) -> Outcome:
    """Update some robots with their pixels.

    A box that implies an impossible speed is refused: a rotating gimbal or compass carries the
    boxes of all robots along.

    Args:
        joint: changed in place.
        slots: (m,) indices of the robots in `joint`.
        pixels: (m, 2) measured.
        sight: the camera.
        model: white noise of pose and boxes.
        fastest: greatest speed of classes without their own, m/s.
        level: factor by which that noise is larger than stated, see `noise_level`.
        alone: whether nothing but these robots is corrected: not the platform's errors, nor others.
    """
    if joint.view is not sight:
        relinearize(joint, sight)
    before = joint.mean
    some = _index(joint, slots)
    linear = _linear(joint, some, before, sight)
    if reinitialize_lost(joint, slots, pixels, linear.seen, sight):
        linear = _linear(joint, some, before, sight)
    if not all(linear.seen.tolist()):
        slots, pixels = slots[linear.seen], pixels[linear.seen]
        some = slots
        linear = _linear(joint, some, before, sight)
    m = len(slots)
    if not m:
        return Outcome(0.0, 0)
    by_state = _times_covariance(joint, some, linear)
    pixel = level * model.pixel
    spread = _innovation(joint, some, linear, by_state, level * model.white + sight.bend)
    spread.reshape(-1)[:: 2 * m + 1] += pixel
    residual = pixels - linear.pixels
    root, white = _whitened(spread, residual)
    squared = float(white @ white)
    # No single box deviates more than all together.
    if squared > TUNING.huber_planar**2 and _soften(spread, residual, pixel):
        root, white = _whitened(spread, residual)
    gain, reduction = _gain(root, by_state)
    if alone:
        _consider_others(gain, reduction, slots)
    joint.mean = before + white @ gain
    change, final = _iterate(joint, before, some, pixels, sight, linear, root, gain, white)
    possible = _possible(joint, some, reduction, fastest)
    if possible is not None:
        joint.mean = before
        rest = correct(
            joint, slots[possible], pixels[possible], sight, model, fastest, level, alone
        )
        refused = np.concatenate([slots[~possible], rest.refused])
        return replace(rest, refused=refused)
    joint.covariance -= reduction
    joint.unseen[some] = 0.0
    _note_velocities(joint, some, change, reduction)
    fits = -0.5 * float(white @ white) - float(np.add.reduce(np.log(root.diagonal())))
    return Outcome(squared, 2 * m, slots[:0], fits, slots, residual, spread, linear, final)


def _gain(root: Array, by_state: Array) -> tuple[Array, Array]:
    """Return the whitened gain (2m, n) and by how much the covariance (n, n) is reduced.

    Schmidt filter: the latency is considered, not estimated; `latency_bank` estimates it.
    """
    # LAPACK's trtrs would do, but OpenBLAS wakes its threads for it whatever the size, and on a
    # busy machine they wait for one another longer than the whole image takes.
    gain = dtrsm(1.0, root, by_state, lower=1)
    reduction = gain.T @ gain
    gain[:, LATENCY] = reduction[LATENCY, LATENCY] = 0.0
    return gain, reduction


def _consider_others(gain: Array, reduction: Array, slots: Indices) -> None:
    """Let a gain (2 m, n) correct some robots only (Schmidt filter).

    What else the state has keeps mean and covariance; correlations with these robots change.

    Args:
        gain: changed in place.
        reduction: (n, n) of the covariance, changed in place.
        slots: of these robots.
    """
    others = np.ones(gain.shape[1], np.bool_)
    others[of_robots(slots)] = False
    gain[:, others] = 0.0
    reduction[np.ix_(others, others)] = 0.0


def _linear(joint: JointState, some: Some, mean: Array, sight: CameraView) -> Linear:
    """Return the linearisation of robots' pixels at some means of the state."""
    return linearise(sight, mean[:COUNT], _shown(joint, some, mean), joint.by_pose[some, :2])


def _note_velocities(joint: JointState, some: Some, change: Array, reduction: Array) -> None:
    """Tell what looks for manoeuvres how velocities were corrected, and how much was expected."""
    corrections = change[COUNT:].reshape(-1, 4)[some, 2:]
    variances = reduction.diagonal()[COUNT:].reshape(-1, 4)[some]
    expected = variances[:, 2] + variances[:, 3]
    joint.manoeuvre_noise.update(some, corrections, expected)
    joint.velocity_changes.update(some, corrections, expected)


def _shown(joint: JointState, some: Some, mean: Array) -> Array:
    """Return where robots are seen (m, 2) by some means of the state."""
    if joint.sway is not None:
        return joint.shown(some, mean)
    places: Array = mean[COUNT:].reshape(-1, 4)[some, :2]
    return places


def _whitened(spread: Array, residual: Array) -> tuple[Array, Array]:
    """Return the lower root of the residual's covariance, and the residual in its units (2 m,).

    Raises:
        numpy.linalg.LinAlgError: the covariance is not positive definite.
    """
    root, failed = dpotrf(spread, lower=1)
    if failed:
        raise np.linalg.LinAlgError("the innovation's covariance is not positive definite")
    return root, dtrsm(1.0, root, residual.reshape(-1, 1), lower=1)[:, 0]


def _iterate(
    joint: JointState,
    before: Array,
    some: Some,
    pixels: Array,
    sight: CameraView,
    linear: Linear,
    root: Array,
    gain: Array,
    white: Array,
) -> tuple[Array, Array]:
    """Iterate the update if it moved a robot far (iterated filter).

    The derivatives stay; only the residual is computed again, less the expected change. Returns the
    change of the mean, and that residual in units of `root`.
    """
    far = TUNING.relinearise_share * float(sight.measured.position[2])
    whole = joint.mean - before
    if whole @ whole <= far * far:  # most often; then no robot moved farther
        return whole, white
    for _ in range(TUNING.max_iterations):
        robots = _shown(joint, some, joint.mean)
        moved = robots - _shown(joint, some, before)
        step: Array = joint.mean - before
        if not (np.abs(moved) > far).any():
            return step, white
        now = linearise(sight, joint.mean[:COUNT], robots)
        if not now.seen.all():
            return step, white
        told = linear.by_platform @ step[:COUNT] + (linear.by_place @ moved[:, :, None])[:, :, 0]
        residual = pixels - now.pixels + told
        white = dtrsm(1.0, root, residual.reshape(-1, 1), lower=1)[:, 0]
        joint.mean = before + white @ gain
    moved_by: Array = joint.mean - before
    return moved_by, white


def _possible(
    joint: JointState, some: Some, reduction: Array, default: float
) -> NDArray[np.bool_] | None:
    """Return the mask (m,) of updated robots that are not too fast; None if all are.

    Args:
        joint: the law.
        some: m robots.
        reduction: of its covariance.
        default: greatest speed of classes without their own, m/s.
    """
    own = joint.own[1, some]
    velocities = np.square(joint.mean[COUNT:].reshape(-1, 4)[some, 2:])
    squared = velocities[:, 0] + velocities[:, 1]
    slowest = min([default, *(2.0 * one for one in own.tolist() if one >= 0.0)])  # NaN: default
    if max(squared.tolist()) <= slowest**2:
        return None
    fastest = np.where(np.isnan(own), default, 2.0 * own)
    speeds = np.sqrt(squared)
    variances = (joint.covariance.diagonal() - reduction.diagonal())[COUNT:].reshape(-1, 4)[some]
    sigma = np.sqrt(variances[:, 2] + variances[:, 3])
    margin = np.minimum(SURE_SIGMAS * sigma, 0.5 * fastest)
    possible: NDArray[np.bool_] = speeds <= fastest + margin
    return None if possible.all() else possible


def _times_covariance(joint: JointState, some: Some, linear: Linear) -> Array:
    """Return H P, (2 m, D); H has the platform's columns and two of one robot in a row."""
    P, m = joint.covariance, len(linear.pixels)
    product: Array = linear.by_platform.reshape(2 * m, COUNT) @ P[:COUNT]
    states = P[COUNT:].reshape(len(joint.rows), 4, -1)
    robots = states[some, :2]
    if joint.sway is not None:
        robots = robots + joint.sway[some, None, None] * states[some, 2:]
    product += (linear.by_place @ robots).reshape(2 * m, -1)
    return product


def _index(joint: JointState, slots: Indices) -> Some:
    """Return the index of some robots: if they are all in order, a slice, which copies nothing."""
    n = len(joint.rows)
    return slice(None) if len(slots) == n and slots.tolist() == [*range(n)] else slots


def _innovation(
    joint: JointState, some: Some, linear: Linear, by_state: Array, white: Array
) -> Array:
    """Return the covariance (2 m, 2 m) of the residual without the boxes' own noise."""
    m = len(linear.pixels)
    spread: Array = by_state[:, :COUNT] @ linear.by_platform.reshape(2 * m, COUNT).T
    states = by_state[:, COUNT:].reshape(2 * m, len(joint.rows), 4)
    robots = states[:, some, :2].swapaxes(0, 1)
    if joint.sway is not None:
        robots = robots + joint.sway[some, None, None] * states[:, some, 2:].swapaxes(0, 1)
    own = robots @ linear.by_place.swapaxes(1, 2)
    spread += own.swapaxes(0, 1).reshape(2 * m, 2 * m)
    by_pose = linear.by_pose.reshape(2 * m, -1)
    spread += (by_pose * white) @ by_pose.T
    return spread


def _soften(spread: Array, residual: Array, pixel: float) -> bool:
    """Down-weight boxes far from their prediction (Huber, from `huber_planar` on).

    Returns whether there was one.

    Weight w = c/d beyond a normalised distance c: the pixel's variance becomes variance / w.
    """
    m = len(residual)
    own = spread.reshape(m, 2, m, 2)
    every = np.arange(m)
    blocks = own[every, :, every]
    distance = np.sqrt(mahalanobis(residual, blocks)[0])
    if max(distance.tolist()) <= TUNING.huber_planar:
        return False
    more = np.maximum(distance / TUNING.huber_planar - 1.0, 0.0)
    # In units of the whole innovation, so that uncertain robots are covered, too.
    for axis in (0, 1):
        own[every, axis, every, axis] += more * np.maximum(blocks[:, axis, axis], pixel)
    return True
