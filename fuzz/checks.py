# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What must hold of every result, whatever came in."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np

from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate
from aerial_gnss_ros.core.values.samples import Array
from fuzz.engine import GUARDED, NOT_FINITE, OUTPUT, WRONG, Broken
from fuzz.flight import Truth

SIGMAS, FAR_M = 4.0, 5.0
"""A position beyond both from every true robot is wrong and confident."""


_CAUGHT = re.compile(r"(\w+(?:Error|Exception))\b(?: at ([\w/.]+))?")
LONGEST = 5000
"""A sentence for a person has no more characters."""


def check_sentence(sentence: str) -> None:
    """Raise Broken where nobody can read what a user is told."""
    if len(sentence) > LONGEST:
        raise Broken(OUTPUT, f"sentence too long: {len(sentence)} characters: {sentence[:80]}")


def check_log(sentences: Sequence[str], failed: int) -> None:
    """Raise Broken where the estimator's last line of defence had work to do.

    Args:
        sentences: of the log.
        failed: images that were given up.
    """
    for sentence in sentences:
        check_sentence(sentence)
        caught = _CAUGHT.search(sentence)
        if caught:
            raise Broken(GUARDED, f"{caught[1]} in {caught[2] or 'reading'}: {sentence}")
    if failed:
        raise Broken(GUARDED, f"images given up: {failed}, and no sentence names the error")


def check(result: FrameResult, truth: Truth | None, phantoms: Array | None = None) -> None:
    """Raise Broken where a result is no result, or a wrong one that is sure of itself.

    Args:
        result: of an image.
        truth: where robots are; None: positions are not judged.
        phantoms: (n, 2) East, North of what was put into images and may be taken for a robot, m.
    """
    for estimate in result.estimates:
        _check_numbers(estimate)
        if truth is not None:
            _check_place(estimate, truth, phantoms)
    for error in result.platform:
        if not (math.isfinite(error.value) and math.isfinite(error.sigma) and error.sigma >= 0.0):
            raise Broken(NOT_FINITE, f"platform error: {error}")
    if result.datum is not None:
        _check_degrees(result.datum.latitude, result.datum.longitude, "map origin")


def _check_numbers(estimate: RobotEstimate) -> None:
    who = estimate.robot_id
    numbers = (*estimate.position, *estimate.velocity, *estimate.covariance.ravel())
    if not all(math.isfinite(number) for number in numbers):
        raise Broken(NOT_FINITE, f"not finite: {who} is at {estimate.position}")
    _check_degrees(estimate.latitude, estimate.longitude, "position")
    if math.isinf(estimate.altitude):
        raise Broken(NOT_FINITE, f"altitude infinite: {who}")
    covariance = estimate.covariance
    if (abs(covariance - covariance.T) > 1e-6 * abs(covariance) + 1e-12).any():
        raise Broken(NOT_FINITE, f"covariance not symmetric: {who} {covariance.tolist()}")
    (east, cross), (_, north) = covariance[:2, :2].tolist()
    if not (east > 0.0 and east * north > cross**2):
        raise Broken(NOT_FINITE, f"covariance not positive: {who} {covariance[:2, :2].tolist()}")
    if np.linalg.eigvalsh(covariance)[0] < -1e-9 * np.trace(covariance):
        raise Broken(NOT_FINITE, f"covariance not positive: {who} {covariance.tolist()}")


def _check_degrees(latitude: float, longitude: float, what: str) -> None:
    # false for NaN
    if not (abs(latitude) <= 0.5 * math.pi and abs(longitude) <= math.pi + 1e-12):
        words = f"{what} no place on Earth: {math.degrees(latitude)}, {math.degrees(longitude)}"
        raise Broken(NOT_FINITE, words)


def _check_place(estimate: RobotEstimate, truth: Truth, phantoms: Array | None) -> None:
    here = truth.local.positions(estimate.latitude, estimate.longitude).reshape(2)
    robots = truth.at(estimate.stamp_ns)
    off = (robots if phantoms is None else np.concatenate([robots, phantoms])) - here
    distance = np.linalg.norm(off, axis=1)
    if distance.min() <= FAR_M:
        return
    squared = np.einsum("ij,ij->i", off, np.linalg.solve(estimate.covariance[:2, :2], off.T).T)
    if squared.min() <= SIGMAS**2:
        return
    sigma = math.sqrt(0.5 * float(np.trace(estimate.covariance[:2, :2])))
    words = (
        f"{estimate.robot_id} ({estimate.state}) is {distance.min():.1f} m off, sigma {sigma:.2f} m"
    )
    raise Broken(WRONG, f"wrong {estimate.state} position: {words}")
