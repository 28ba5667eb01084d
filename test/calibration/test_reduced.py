# SPDX-License-Identifier: Apache-2.0
"""Elimination of each image's own errors, against the whole system of equations."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.calibration.model import Residuals
from aerial_gnss_ros.calibration.reduced import HUBER, reduced

IMAGES, UNKNOWNS, PIXEL = 3, 4, 2.0


def test_the_reduced_equations_solve_the_whole_system():
    rng = np.random.default_rng(3)
    images = np.array([0, 0, 1, 2, 2, 2])  # boxes of three images
    rows = Residuals(
        rng.normal(0.0, 2.0, (len(images), 2)), rng.normal(0.0, 3.0, (len(images), 2, UNKNOWNS)),
        rng.normal(0.0, 3.0, (len(images), 2, 6)), images,
    )  # fmt: skip
    rows.values[4] *= 20.0  # one that counts less
    own, variances = rng.normal(0.0, 0.1, (IMAGES, 6)), rng.uniform(0.05, 0.2, 6)
    found = reduced(rows, own, variances, PIXEL)
    step = np.linalg.solve(found.normal, found.gradient)

    whole = np.zeros((2 * len(images), UNKNOWNS + 6 * IMAGES))
    for box, image in enumerate(images):
        whole[2 * box : 2 * box + 2, :UNKNOWNS] = rows.jacobian[box]
        first = UNKNOWNS + 6 * image
        whole[2 * box : 2 * box + 2, first : first + 6] = rows.by_own[box]
    distance = np.linalg.norm(rows.values, axis=1) / np.sqrt(PIXEL)
    weight = np.repeat(np.minimum(1.0, HUBER / distance), 2) / PIXEL
    prior = np.concatenate([np.zeros(UNKNOWNS), np.tile(1.0 / variances, IMAGES)])
    normal = (whole.T * weight) @ whole + np.diag(prior)
    gradient = (whole.T * weight) @ rows.values.ravel()
    gradient[UNKNOWNS:] -= prior[UNKNOWNS:] * own.ravel()
    expected = np.linalg.solve(normal, gradient)
    np.testing.assert_allclose(step, expected[:UNKNOWNS])
    np.testing.assert_allclose(found.own_step(step).ravel(), expected[UNKNOWNS:])
    covariance = np.linalg.inv(normal)[:UNKNOWNS, :UNKNOWNS]
    np.testing.assert_allclose(np.linalg.inv(found.normal), covariance)
